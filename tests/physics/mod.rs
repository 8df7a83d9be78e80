//! Exact solutions and laws, module by module.

mod cholesky;
mod latin_hypercube;
mod lbfgsb;
mod normal;
