//! Exact solutions and laws, module by module.

mod cholesky;
mod design;
mod gp;
mod latin_hypercube;
mod lbfgsb;
mod normal;
