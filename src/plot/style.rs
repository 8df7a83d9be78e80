//! The one look of every figure: colours, line widths, dashes, font sizes, units.
//!
//! Colours follow the paper (PIC orange, NIC blue, CIC green, truth black, envelope red), darkened where a thin line on
//! white would fade; every method also has its own dash or mark, so that no figure depends on telling colours apart.

use plotters::style::RGBColor;

/// Font families, the first one wanted: its metrics are what `svg::text_width` estimates.
pub const FONTS: &str = "'DejaVu Sans', Verdana, 'Bitstream Vera Sans', Arial, Helvetica, sans-serif";
/// Size of tick labels, px.
pub const TICK_SIZE: f64 = 10.0;
/// Size of axis labels and legends, px.
pub const LABEL_SIZE: f64 = 11.0;
/// Size of titles, px.
pub const TITLE_SIZE: f64 = 12.0;
/// Size of small notes, px.
pub const NOTE_SIZE: f64 = 9.0;

/// Width of a method's line, px.
pub const LINE: f64 = 1.7;
/// Width of a line that shares its panel with thousands of samples, px.
pub const FINE_LINE: f64 = 0.9;
/// Width of frames, px.
pub const FRAME_LINE: f64 = 0.8;
/// Width of grid lines, px.
pub const GRID_LINE: f64 = 0.6;
/// The unit of epsilon_1, marked up.
pub const EPSILON_UNIT: &str = "m^{−1} s^{−2}";
/// Radius of a dot of the truth, px.
pub const DOT: f64 = 1.9;

/// Truth, text.
pub const BLACK: RGBColor = RGBColor(20, 20, 20);
/// Frames and ticks.
pub const FRAME: RGBColor = RGBColor(90, 90, 90);
/// Secondary text.
pub const GREY: RGBColor = RGBColor(95, 95, 95);
/// Major grid lines.
pub const GRID: RGBColor = RGBColor(228, 228, 228);
/// Paper.
pub const WHITE: RGBColor = RGBColor(255, 255, 255);
/// NIC, VHGP-Seq, elevation: the paper's `RoyalBlue`.
pub const BLUE: RGBColor = RGBColor(32, 88, 204);
/// PIC, random sampling: the paper's `BurntOrange`.
pub const ORANGE: RGBColor = RGBColor(232, 110, 4);
/// CIC: the paper's `Green`.
pub const GREEN: RGBColor = RGBColor(10, 130, 62);
/// Envelope: the paper's `Red`.
pub const RED: RGBColor = RGBColor(208, 32, 38);
/// A setting that is varied, first shade.
pub const PURPLE: RGBColor = RGBColor(128, 50, 150);
/// A setting that is varied, second shade.
pub const TEAL: RGBColor = RGBColor(0, 136, 146);

/// One of the five curves of Figure 3.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Method {
    /// P_true, from the long record.
    Truth,
    /// Constant initial condition.
    Cic,
    /// Pre-computed initial condition.
    Pic,
    /// Natural initial condition, driven by the record.
    Nic,
    /// Natural initial condition, driven by reconstructed groups.
    NicGroups,
}

impl Method {
    /// Every method in the order of legends.
    pub const ALL: [Method; 5] = [Method::Truth, Method::Cic, Method::Pic, Method::Nic, Method::NicGroups];

    /// The name in the CSV files.
    pub fn name(self) -> &'static str {
        match self {
            Method::Truth => "truth",
            Method::Cic => "cic",
            Method::Pic => "pic",
            Method::Nic => "nic",
            Method::NicGroups => "nic_groups",
        }
    }

    /// The method of a name in the CSV files.
    pub fn named(name: &str) -> Option<Method> {
        Method::ALL.into_iter().find(|method| method.name() == name)
    }

    /// The name in legends.
    pub fn label(self) -> &'static str {
        match self {
            Method::Truth => "truth",
            Method::Cic => "CIC",
            Method::Pic => "PIC",
            Method::Nic => "NIC",
            Method::NicGroups => "NIC from reconstructed groups",
        }
    }

    /// The colour of line and marks.
    pub fn colour(self) -> RGBColor {
        match self {
            Method::Truth => BLACK,
            Method::Cic => GREEN,
            Method::Pic => ORANGE,
            Method::Nic | Method::NicGroups => BLUE,
        }
    }

    /// Lengths of dash and gap in turn, px; empty for a solid line.
    pub fn dash(self) -> &'static [f64] {
        match self {
            Method::Cic => &[7.0, 2.0, 1.5, 2.0],
            Method::NicGroups => &[3.6, 2.0],
            Method::Truth | Method::Pic | Method::Nic => &[],
        }
    }
}
