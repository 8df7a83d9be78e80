//! The last stages: one published name, one file; data in, text out.

pub mod calibration;
pub mod fig1_wave_groups;
pub mod fig2_flowchart;
pub mod fig3_exceedance;
pub mod fig4_response_moments;
pub mod fig5_vhgp_seq;
pub mod fig6_jonswap_groups;
pub mod groups;
pub mod scenes;
pub mod table1;
pub mod truth;
