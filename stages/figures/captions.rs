//! What stands beside each figure on the page, in our own words.

/// The words beside a figure.
pub struct Caption {
    /// Name of the figure.
    pub name: &'static str,
    /// Heading.
    pub title: &'static str,
    /// What it shows.
    pub shows: &'static str,
    /// What to look for.
    pub look_for: &'static str,
}

/// The captions in the order of the figures.
pub const CAPTIONS: [Caption; 8] = [
    Caption {
        name: "fig1_wave_groups",
        title: "Figure 1: wave groups and their statistics",
        shows: "(a) A stretch of surface elevation with its envelope. (b) The envelope and the Gaussian groups that the \
                detection fits to it, each with a centre, a length L and an amplitude A. (c) The joint density of L and A over \
                all groups of the record.",
        look_for: "Successive groups share flanks: a ship that meets one still rolls from the one before. That is the initial \
                   condition the methods differ in.",
    },
    Caption {
        name: "fig2_flowchart",
        title: "Figure 2: the three methods",
        shows: "How each method turns groups into an exceeding probability: CIC starts at rest, PIC from states drawn from \
                continuous roll, NIC two groups ahead in the ship's own waves.",
        look_for: "Only NIC keeps the connection between a group and the state in which the ship meets it.",
    },
    Caption {
        name: "fig3_exceedance",
        title: "Figure 3: exceeding probability by every method",
        shows: "The probability that the largest roll in a group exceeds a threshold, one row per sea and one column per \
                strength of parametric excitation, by the truth (dots), CIC, PIC and NIC; NIC also from reconstructed groups \
                (dashed). Beside it the joint density of group length and amplitude.",
        look_for: "Where CIC falls below the dots at large thresholds, where PIC lies above them, and how NIC from the record \
                   stays on them while NIC from reconstructed groups does not. NIC from the record sees the truth's own waves, so \
                   it tests the initial condition, not the loss of phases.",
    },
    Caption {
        name: "fig4_response_moments",
        title: "Figure 4: mean and spread of the response to one group",
        shows: "Mean (above) and standard deviation (below) of the largest roll in groups of three lengths and amplitudes, by \
                every method, against the parametric excitation.",
        look_for: "CIC has no spread at all. The paper finds PIC's rings above the dots where the excitation is weak, in mean and \
                   in spread, and upon them where it is strong, and NIC's upon them everywhere.",
    },
    Caption {
        name: "fig5_vhgp_seq",
        title: "Figure 5: sequential against random sampling",
        shows: "(a) Estimated probability against the number of simulated groups, by VHGP-Seq and by random sampling: mean and one \
                standard deviation above it over independent realisations; dashed the truth. (b, not in the paper) The \
                root-mean-square error, bias and spread together: also of a design that looks ahead, the same with the \
                response of linear oscillators as a control, and VHGP-Seq's surrogate on a Latin hypercube; dotted the least of \
                an unbiased estimate by a smooth normal model of the roll over length and amplitude.",
        look_for: "How narrow the blue band is with 120 samples, and how many random samples have the same error in (b): the \
                   paper finds more than a thousand.",
    },
    Caption {
        name: "fig6_jonswap_groups",
        title: "Figure 6: groups in the JONSWAP sea",
        shows: "A stretch of the broader JONSWAP sea and the Gaussian groups found in it.",
        look_for: "The groups are shorter and fit less well than in the narrow seas.",
    },
    Caption {
        name: "fig7_temporal",
        title: "Figure 7 (not in the paper): probability by groups and by time",
        shows: "(a) The probability by groups for three similarity thresholds of the detection. (b) The share of time that the \
                roll angle exceeds a threshold: of the whole roll (dots), and the part of it within the detected groups \
                (lines). (c) Each relative to its reference.",
        look_for: "A stricter detection drops small groups and so raises the probability by groups. The share of time of the \
                   whole roll knows no detection; the thin lines of (c) tell how much of it lies within the groups.",
    },
    Caption {
        name: "fig8_method_error",
        title: "Figure 8 (not in the paper): the error of each method",
        shows: "Figure 3 relative to the truth: each method's probability over that of the truth. Grey: where two standard \
                errors of both together, the truth and an estimate as good as it from as many groups as the methods run on, \
                would leave a right method.",
        look_for: "A method that leaves the grey band is wrong, not unlucky.",
    },
];
