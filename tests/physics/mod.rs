//! Exact solutions and laws, module by module.

mod lbfgsb;
