//! Exact solutions and laws, module by module.

mod cholesky;
mod density;
mod design;
mod detection;
mod detection_twin;
mod elementary;
mod encounter;
mod envelope;
mod exceedance;
mod fourier;
mod gp;
mod ground_truth;
mod group_statistics;
mod hermite;
mod latin_hypercube;
mod lbfgsb;
mod normal;
mod response;
mod rk4;
mod roll_equation;
mod roll_twin;
mod seas;
mod self_test;
mod sums;
mod traps;
mod wave_field;
