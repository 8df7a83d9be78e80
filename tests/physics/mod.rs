//! Exact solutions and laws, module by module.

mod cholesky;
mod gp;
mod latin_hypercube;
mod lbfgsb;
mod normal;
