//! Exact solutions and laws, module by module.

mod density;
mod detection;
mod envelope;
mod fourier;
mod group_statistics;
mod lbfgsb;
mod seas;
mod wave_field;
mod cholesky;
mod design;
mod gp;
mod latin_hypercube;
mod lbfgsb;
mod normal;
mod encounter;
mod exceedance;
mod hermite;
mod response;
mod rk4;
mod roll_equation;
mod roll_twin;
