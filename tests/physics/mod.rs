//! Exact solutions and laws, module by module.
