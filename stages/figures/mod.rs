//! The last stages: one published name, one file; data in, text out.

pub mod calibration;
pub mod captions;
pub mod evidence;
pub mod fig1_wave_groups;
pub mod fig2_flowchart;
pub mod fig3_exceedance;
pub mod fig4_response_moments;
pub mod fig5_vhgp_seq;
pub mod fig6_jonswap_groups;
pub mod fig7_temporal;
pub mod fig8_method_error;
pub mod findings;
pub mod groups;
pub mod index;
pub mod panels;
pub mod refusal;
pub mod scenes;
pub mod table1;
pub mod table_rows;
pub mod truth;
