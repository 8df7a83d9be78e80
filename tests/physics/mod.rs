//! Exact solutions and laws, module by module.

mod encounter;
mod exceedance;
mod hermite;
mod response;
mod rk4;
mod roll_equation;
mod roll_twin;
