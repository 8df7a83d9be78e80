//! Every figure: its entries, its curves, its limits and its degenerate inputs.

use encounter::plot::convergence::{self, Estimates};
use encounter::plot::exceedance::{self, Exceedance};
use encounter::plot::style::Method;
use encounter::plot::wave_groups::Series;
use encounter::plot::{flowchart, jonswap_groups, method_error, response_moments, table, temporal, wave_groups};

use super::{samples, svg};

/// Every figure of the paper from synthetic input, by its published name.
fn all() -> Vec<(&'static str, String)> {
    let drawn = "the samples are sound";
    vec![
        (
            "fig1_wave_groups",
            wave_groups::draw(&samples::wave_groups()).expect(drawn),
        ),
        ("fig2_flowchart", flowchart::draw(2).expect(drawn)),
        (
            "fig3_exceedance",
            exceedance::draw(&samples::exceedance(4, 3)).expect(drawn),
        ),
        (
            "fig4_response_moments",
            response_moments::draw(&samples::response_moments()).expect(drawn),
        ),
        (
            "fig5_vhgp_seq",
            convergence::draw(&samples::convergence()).expect(drawn),
        ),
        (
            "fig6_jonswap_groups",
            jonswap_groups::draw(&samples::jonswap_groups()).expect(drawn),
        ),
        ("fig7_temporal", temporal::draw(&samples::temporal()).expect(drawn)),
        (
            "fig8_method_error",
            method_error::draw(&samples::method_error()).expect(drawn),
        ),
        ("table1", table::svg(&samples::table()).expect(drawn)),
        (
            "fig3_six_seas",
            exceedance::draw(&samples::exceedance(6, 3)).expect(drawn),
        ),
        ("fig3_hostile", exceedance::draw(&samples::hostile()).expect(drawn)),
        (
            "fig3_one_sea",
            exceedance::draw(&samples::exceedance(1, 1)).expect(drawn),
        ),
    ]
}

#[test]
fn every_figure_is_well_formed_small_and_within_its_sheet() {
    for (name, drawn) in all() {
        if let Ok(folder) = std::env::var("ENCOUNTER_PLOTS") {
            std::fs::write(format!("{folder}/{name}.svg"), &drawn).expect("the folder can be written");
            println!("{name} {}", drawn.len());
        }
        svg::check(&drawn);
    }
}

#[test]
fn a_method_is_found_by_its_name() {
    for method in Method::ALL {
        assert_eq!(Method::named(method.name()), Some(method));
    }
    assert_eq!(Method::named("guess"), None);
}

#[test]
fn equal_input_gives_equal_bytes() {
    assert_eq!(all(), all());
}

#[test]
fn figure_1_draws_every_group_and_names_its_lines() {
    let figure = samples::wave_groups();
    let drawn = wave_groups::draw(&figure).expect("the sample is sound");
    let words = svg::words(&drawn);
    for wanted in [
        "elevation η",
        "envelope ρ",
        "Gaussian groups ρi",
        "time t / Tp",
        "L / Tp",
        "A / Hs",
        "(a)",
        "(b)",
        "(c)",
    ] {
        assert!(words.iter().any(|word| word == wanted), "{wanted} is missing");
    }
    let black = svg::stroked(&drawn, "#141414");
    assert_eq!(
        black,
        figure.groups.len() + 1,
        "a line for each group and one in the legend"
    );
    assert!(
        svg::count(&drawn, "polygon") > 8,
        "the density has bands and a colour bar"
    );
}

#[test]
fn figure_2_names_three_methods_and_their_equations() {
    let drawn = flowchart::draw(3).expect("nothing to fail");
    let words = svg::words(&drawn).join("|");
    for wanted in [
        "CIC",
        "PIC",
        "NIC",
        "(1)",
        "(2)",
        "(3)",
        "(4)",
        "(5)",
        "(6)",
        "three groups ahead",
    ] {
        assert!(words.contains(wanted), "{wanted} is missing");
    }
}

#[test]
fn figure_3_has_a_row_per_sea_and_one_legend() {
    let figure = samples::exceedance(4, 3);
    let drawn = exceedance::draw(&figure).expect("the sample is sound");
    let words = svg::words(&drawn);
    for method in [Method::Cic, Method::Pic, Method::Nic, Method::NicGroups] {
        assert_eq!(
            words.iter().filter(|word| *word == method.label()).count(),
            1,
            "{}",
            method.label()
        );
    }
    for (i, row) in figure.rows.iter().enumerate() {
        let title = format!("({}) {}", char::from(b'a' + i as u8), row.spectrum);
        assert!(words.contains(&title), "{title} is missing");
        assert!(words.contains(&row.description), "{} is missing", row.description);
    }
    let heads = ["0", "0.002", "0.004"].map(|value| format!("ε1 = {value} m−1 s−2"));
    for head in heads.iter().map(String::as_str).chain(["10⁻¹", "10⁻⁴", "1"]) {
        assert!(words.iter().any(|word| word == head), "{head} is missing");
    }
    let orange = svg::stroked(&drawn, "#E86E04");
    assert_eq!(orange, 4 * 3 + 1, "a PIC line for each panel and one in the legend");
}

#[test]
fn a_zero_probability_is_not_drawn() {
    let mut figure = samples::exceedance(1, 1);
    for curve in &mut figure.rows[0].cells[0].curves {
        curve.probability.fill(0.0);
        curve.standard_error.fill(0.0);
    }
    let drawn = exceedance::draw(&figure).expect("zeros are sound");
    svg::check(&drawn);
    assert_eq!(svg::count(&drawn, "circle"), 1, "the legend's dot alone is left");
    assert_eq!(svg::stroked(&drawn, "#E86E04"), 1, "and the legend's line");
}

#[test]
fn dots_stand_at_every_second_of_many_positive_probabilities_inside_the_frame() {
    let figure = samples::exceedance(1, 1);
    let truth = &figure.rows[0].cells[0].curves[0];
    assert!((40..80).contains(&truth.probability.len()), "one dot in two");
    let seen = truth.probability.iter().step_by(2).filter(|p| **p >= 1e-5).count();
    let drawn = exceedance::draw(&figure).expect("the sample is sound");
    assert_eq!(svg::count(&drawn, "circle"), seen + 1);
}

#[test]
fn figure_4_shows_every_method_at_every_shape() {
    let drawn = response_moments::draw(&samples::response_moments()).expect("the sample is sound");
    let words = svg::words(&drawn);
    for wanted in [
        "truth",
        "CIC",
        "PIC",
        "NIC",
        "mean of R (rad)",
        "std. dev. of R (rad)",
        "(a)",
        "(f)",
    ] {
        assert!(words.iter().any(|word| word == wanted), "{wanted} is missing");
    }
    assert!(
        words
            .iter()
            .any(|word| word == "L/Tp = 1.5, A/Hs = 0.35 (1,234 groups)")
    );
    let green = svg::stroked(&drawn, "#0A823E");
    assert_eq!(
        green,
        2 * 3 * (1 + 3 + 3) + 1,
        "a line, three bars and three rings in each of six panels, and the legend's line"
    );
}

#[test]
fn figure_5_shades_one_side_of_the_mean_only() {
    let figure = samples::convergence();
    let drawn = convergence::draw(&figure).expect("the sample is sound");
    assert_eq!(
        svg::count(&drawn, "polygon"),
        2 + 2,
        "two shades and their samples in the legend"
    );
    let lowest = |name: &str, colour: &str| {
        let all = svg::elements(&drawn);
        let mut found = all.iter().filter(|e| {
            e.name == name && (e.attribute("stroke") == Some(colour) || e.attribute("fill") == Some(colour))
        });
        let points = found
            .next()
            .and_then(|e| e.attribute("points"))
            .expect("it is drawn")
            .to_owned();
        points
            .split(' ')
            .map(|p| p.split(',').nth(1).expect("a pair").parse::<i64>().expect("a number"))
            .max()
            .expect("points")
    };
    assert!(
        lowest("polygon", "#2058CC") <= lowest("polyline", "#2058CC") + 1,
        "the shade does not reach below the mean"
    );
    let words = svg::words(&drawn);
    for wanted in [
        "30",
        "100",
        "300",
        "1000",
        "3000",
        "number of samples",
        "Ptrue",
        "VHGP-Seq, mean",
    ] {
        assert!(words.iter().any(|word| word == wanted), "{wanted} is missing");
    }
}

#[test]
fn a_narrow_figure_breaks_its_legend_into_lines() {
    let mut figure = samples::response_moments();
    figure.shapes.truncate(1);
    let mut again = figure.shapes[0].moments[3].clone();
    again.method = Method::NicGroups;
    figure.shapes[0].moments.push(again);
    let drawn = response_moments::draw(&figure).expect("one shape is sound");
    svg::check(&drawn);
    let height = |name: &str| {
        let all = svg::elements(&drawn);
        let found = all
            .iter()
            .find(|element| element.text == name)
            .expect("it is in the legend");
        found.attribute("y").expect("it has a place").to_owned()
    };
    assert_ne!(height("truth"), height("NIC from reconstructed groups"));
}

#[test]
fn nothing_known_is_still_a_figure() {
    let empty = Exceedance {
        ship: String::new(),
        rows: Vec::new(),
    };
    svg::check(&exceedance::draw(&empty).expect("no sea is sound"));
    let mut figure = samples::exceedance(1, 2);
    for cell in &mut figure.rows[0].cells {
        cell.curves.clear();
    }
    figure.rows[0].density.p.fill(0.0);
    svg::check(&exceedance::draw(&figure).expect("no curve is sound"));
    let mut figure = samples::wave_groups();
    figure.eta = Series::default();
    figure.rho = Series::default();
    figure.groups.clear();
    svg::check(&wave_groups::draw(&figure).expect("no waves are sound"));
    let mut figure = samples::response_moments();
    figure.shapes.clear();
    svg::check(&response_moments::draw(&figure).expect("no shape is sound"));
    let mut figure = samples::convergence();
    for none in [
        &mut figure.sequential,
        &mut figure.best,
        &mut figure.control,
        &mut figure.lhs,
    ] {
        *none = Estimates::default();
    }
    figure.random = Estimates {
        n_samples: vec![30.0],
        mean: vec![0.0],
        std: vec![Some(0.0)],
    };
    figure.p_true = None;
    svg::check(&convergence::draw(&figure).expect("a single point is sound"));
}

#[test]
fn a_long_name_is_cut_and_a_hostile_one_escaped() {
    let mut figure = samples::exceedance(1, 1);
    figure.rows[0].spectrum = "a_sea_whose_name_is_far_too_long_for_any_figure_that_was_ever_printed_".repeat(4);
    figure.rows[0].description = "<script>&\"'".repeat(60);
    let drawn = exceedance::draw(&figure).expect("a name is no reason to fail");
    svg::check(&drawn);
    assert!(svg::words(&drawn).iter().any(|word| word.ends_with('…')));
    let mut figure = samples::convergence();
    figure.spectrum = figure.spectrum.repeat(200);
    svg::check(&convergence::draw(&figure).expect("a name is no reason to fail"));
}

#[test]
fn what_is_not_finite_breaks_the_line_and_is_not_written() {
    let mut figure = samples::exceedance(1, 1);
    figure.rows[0].cells[0].curves[2].probability[5] = f64::NAN;
    figure.rows[0].cells[0].curves[0].standard_error[6] = f64::INFINITY;
    figure.rows[0].density.p[77] = f64::NAN;
    let drawn = exceedance::draw(&figure).expect("it is left out");
    svg::check(&drawn);
    assert_eq!(svg::stroked(&drawn, "#E86E04"), 2 + 1, "PIC's line is in two parts");
    assert!(!exceedance::csv(&[&figure]).contains("NaN"));
}

#[test]
fn arrays_of_different_length_are_refused() {
    let mut figure = samples::exceedance(1, 1);
    figure.rows[0].cells[0].curves[0].probability.pop();
    let error = exceedance::draw(&figure).expect_err("a value is missing");
    assert_eq!(error.to_string(), "probability: expected 49 values, found 48");
}

#[test]
fn a_curve_of_one_threshold_is_a_mark() {
    let mut figure = samples::exceedance(1, 1);
    for curve in &mut figure.rows[0].cells[0].curves {
        for values in [&mut curve.theta_t, &mut curve.probability, &mut curve.standard_error] {
            values.truncate(1);
        }
        (curve.theta_t[0], curve.probability[0]) = (0.7, 0.01);
    }
    let drawn = exceedance::draw(&figure).expect("one threshold is sound");
    svg::check(&drawn);
    for (method, colour) in [("CIC", "#0A823E"), ("PIC", "#E86E04"), ("NIC", "#2058CC")] {
        let mark = drawn
            .lines()
            .any(|line| line.contains("<circle") && line.contains(colour))
            || drawn.contains(&format!("fill=\"{colour}\""));
        assert!(mark, "{method} has vanished");
    }
}

#[test]
fn a_standard_error_that_tells_nothing_is_empty_in_the_data_and_has_no_bar() {
    let mut figure = samples::exceedance(1, 1);
    let curve = &mut figure.rows[0].cells[0].curves[0];
    (curve.probability[0], curve.standard_error[0]) = (1.0, 0.0);
    (curve.probability[1], curve.standard_error[1]) = (0.5, 0.0);
    let (method, theta_t) = (curve.method.name(), curve.theta_t.clone());
    let text = exceedance::csv(&[&figure]);
    let row = |i: usize| {
        let place = format!(",{},{method},", theta_t[i]);
        text.lines().find(|line| line.contains(&place)).unwrap_or_default()
    };
    assert!(row(0).contains(&format!(",{method},1,0,")), "{}", row(0));
    assert!(row(1).contains(&format!(",{method},0.5,,")), "{}", row(1));
}

#[test]
fn a_single_realisation_has_no_spread_to_draw_or_write() {
    let mut figure = samples::convergence();
    figure.realisations = 1;
    for estimates in [&mut figure.sequential, &mut figure.random] {
        estimates.std.fill(None);
    }
    let drawn = convergence::draw(&figure).expect("no spread is sound");
    svg::check(&drawn);
    assert!(svg::words(&drawn).iter().any(|word| word.ends_with(", 1 realisation")));
    let text = convergence::csv(&figure);
    let row = text.lines().find(|line| line.starts_with("sequential,30,"));
    assert!(row.is_some_and(|row| row.ends_with(',')), "{row:?}");
}

#[test]
fn a_sea_of_a_millimetre_and_one_of_a_kilometre_fill_their_panels() {
    for size in [1e-3, 1e3] {
        let mut figure = samples::wave_groups();
        for value in figure.eta.value.iter_mut().chain(&mut figure.rho.value) {
            *value *= size;
        }
        let (largest, limit) = (figure.eta.largest(), wave_groups::elevation_limit(figure.eta.largest()));
        assert!(limit >= largest && limit < 2.5 * largest, "{limit} for {largest}");
        svg::check(&wave_groups::draw(&figure).expect("any size is sound"));
    }
}
