//! Published sets: one set at a time, links, names, temporary files, and what is provably ours.

use std::collections::BTreeMap;
use std::fs::{self, File};
use std::os::unix::fs::{PermissionsExt, symlink};
use std::path::Path;

use crate::common::House;
use crate::common::toy::SCALE;
use encounter::engine::checkout::{Checkout, check_name, derived_name};
use encounter::engine::event::Event;
use encounter::engine::leftover::{Due, remove_leftovers};
use encounter::engine::params::ParamsFile;
use encounter::engine::publish::{self, publish};
use encounter::engine::run::Run;

const NOTHING: [&str; 0] = [];

fn text(path: &Path) -> String {
    fs::read_to_string(path).unwrap_or_else(|why| panic!("{}: {why}", path.display()))
}

/// What publishing some texts, whoever made them, says.
fn published(house: &House, texts: &[(&str, &str)]) -> Result<(), String> {
    let graph = house.graph(&[]).expect("the parameters are in order");
    let store = house.store();
    let run = Run::new(&graph, &store, &|_: &Event| {});
    let texts: BTreeMap<String, String> = texts
        .iter()
        .map(|(path, text)| ((*path).to_owned(), (*text).to_owned()))
        .collect();
    let due = Due::new(&house.pipeline, &["small".to_owned(), "large".to_owned()]);
    house
        .with_set(|set| publish(&run, &texts, &due, set))
        .map_err(|error| error.to_string())
}

#[test]
fn a_name_that_is_no_plain_one_is_refused_and_nothing_is_written() {
    let house = House::lived_in(&[]);
    let before = house.files_in("");
    let outside = house.path("outside.csv");
    let absolute = outside.display().to_string();
    for name in [
        "../outside.csv",
        "large/../../outside.csv",
        absolute.as_str(),
        "a/b/report.csv",
        "",
        ".",
        "..",
        "large/",
        ".hidden.csv",
        "large/.hidden.csv",
        "report\n.csv",
        "report\u{1b}[2J.csv",
        "report\\x.csv",
        "r\u{e9}port.csv",
        "C:report.csv",
    ] {
        let refusal = published(&house, &[("report.csv", "new"), (name, "hostile")]);
        let refusal = refusal.expect_err(name);
        assert!(
            refusal.contains("expected a plain name within the figures folder"),
            "{refusal}"
        );
        assert!(!refusal.contains('\u{1b}'), "{refusal:?}");
    }
    assert_eq!(house.files_in(""), before);
    assert!(!outside.exists());
    assert_ne!(text(&house.path("figures/report.csv")), "new");
}

#[test]
fn an_output_that_names_files_its_stage_does_not_publish_is_refused_when_it_is_decoded() {
    use encounter::engine::codec::encode;
    use encounter::engine::stage::Published;
    let house = House::new();
    let graph = house.graph(&["report"]).expect("the parameters are in order");
    let report = graph.nodes.iter().find(|node| node.node.name() == "report");
    let report = report.expect("there is a report").node;
    let of = |name: &str| {
        let files = BTreeMap::from([(name.to_owned(), "text".to_owned())]);
        report.published(&encode(&Published { files }).expect("texts can be encoded"))
    };
    for name in [
        "report.csv",
        "report.md",
        "report_more.svg",
        "report.tex",
        "report.html",
    ] {
        assert!(of(name).is_ok(), "{name}");
    }
    for name in [
        "../../../home/.ssh/authorized_keys",
        "/etc/report.csv",
        "pinned.csv",
        "reporter.csv",
        "report",
        "report.sh",
        "report.csv.lock",
        "report.csv/",
        "report_/x.csv",
        ".report.csv",
        "Report.csv",
        "report_\u{7f}.csv",
        "report_a.b.csv",
    ] {
        let error = of(name).expect_err(name);
        let said = error.to_string();
        assert_eq!(error.exit_code(), 5, "{said}");
        assert!(said.contains("which this stage does not publish"), "{said}");
    }
}

#[test]
fn a_link_in_place_of_a_folder_is_refused_by_name_and_its_target_is_left_alone() {
    for (link, folder) in [("figures/large", "elsewhere"), ("figures/large", "figures/other")] {
        let house = House::lived_in(&[]);
        fs::remove_dir_all(house.path(link)).expect("the folder can be deleted");
        fs::create_dir(house.path(folder)).expect("a folder can be made");
        symlink(house.path(folder), house.path(link)).expect("a link can be made");
        let error = house.run().outcome.expect_err("a link is refused");
        let said = error.to_string();
        assert!(
            said.contains("figures/large: expected a folder, found a link"),
            "{said}"
        );
        assert_eq!((error.exit_code(), house.files_in(folder).len()), (2, 0));
    }
    let house = House::lived_in(&[]);
    fs::remove_dir_all(house.path("artifacts/edited")).ok();
    fs::create_dir(house.path("elsewhere")).expect("a folder can be made");
    symlink(house.path("elsewhere"), house.path("artifacts/edited")).expect("a link can be made");
    fs::write(house.path("figures/report.csv"), "mine").expect("a figure can be edited");
    let said = house.run().outcome.expect_err("a link is refused").to_string();
    assert!(
        said.contains("artifacts/edited: expected a folder, found a link"),
        "{said}"
    );
    assert_eq!(house.files_in("elsewhere").len(), 0);
    assert_eq!(text(&house.path("figures/report.csv")), "mine");
}

#[test]
fn an_error_before_the_first_rename_leaves_the_old_set_as_it_was() {
    let house = House::lived_in(&[]);
    let before: Vec<String> = house.files_in("figures").iter().map(|path| text(path)).collect();
    let table = house.path("figures/report.md");
    fs::remove_file(&table).expect("a figure can be deleted");
    fs::create_dir(&table).expect("a folder can be made");
    let refusal = published(
        &house,
        &[("pinned.csv", "new"), ("report.csv", "new"), ("report.md", "new")],
    );
    assert!(refusal.expect_err("a folder is in the way").contains("report.md"));
    fs::remove_dir(&table).expect("the folder is empty");
    assert_eq!(house.run().written(), ["report.md"]);
    let after: Vec<String> = house.files_in("figures").iter().map(|path| text(path)).collect();
    assert_eq!(after, before);
}

#[test]
fn published_files_have_the_permissions_that_the_mask_of_the_user_leaves() {
    let house = House::lived_in(&[]);
    let plain = house.path("plain");
    File::create(&plain).expect("a file can be made");
    let mode = |path: &Path| fs::metadata(path).expect("the file is there").permissions().mode();
    for path in house.files_in("figures") {
        assert_eq!(mode(&path), mode(&plain), "{}", path.display());
    }
}

#[test]
fn what_is_not_provably_ours_stays_in_the_figures_folder() {
    let house = House::lived_in(&[]);
    let strange = [
        "figures/table.0123456789abcdef.tmp",
        "figures/.encounter-0123456789abcde.tmp",
        "figures/.encounter-0123456789abcd_f.tmp",
        "figures/.encounter-0123456789abcdef.tmp2",
        "figures/notes.csv",
        "figures/report.csv.bak",
        "figures/mine/report.csv",
        "artifacts/thesis.0123456789abcdef.tmp",
    ];
    fs::create_dir(house.path("figures/mine")).expect("a folder can be made");
    for name in strange {
        fs::copy(house.path("figures/report.csv"), house.path(name)).expect("a file can be copied");
    }
    symlink(
        house.path("plain"),
        house.path("figures/.encounter-00000000000000ff.tmp"),
    )
    .expect("a link can be made");
    let ours = house.path("figures/.encounter-0123456789abcdef.tmp");
    fs::write(&ours, "half a fig").expect("a file can be written");
    house.run().expect_success();
    assert!(!ours.exists());
    assert!(strange.iter().all(|name| house.path(name).exists()));
    assert!(
        house
            .path("figures/.encounter-00000000000000ff.tmp")
            .symlink_metadata()
            .is_ok()
    );
    let due = Due::new(&house.pipeline, &["small".to_owned()]);
    let (removed, kept) = house
        .with_set(|set| remove_leftovers(&due, set, false))
        .expect("leftovers can be removed");
    // A copy elsewhere has our bytes, but no run put it there.
    assert_eq!(removed, ["large/pinned.csv", "large/report.csv", "large/report.md"]);
    assert_eq!(kept, NOTHING);
    assert!(strange.iter().all(|name| house.path(name).exists()));
}

#[test]
fn files_of_a_value_that_is_no_longer_run_are_named_and_one_command_removes_all_but_edited_ones() {
    let mut house = House::lived_in(&[]);
    house.set("run.scales=[\"small\"]");
    let done = house.run();
    assert_eq!(
        done.old(),
        ["large/pinned.csv Kept", "large/report.csv Kept", "large/report.md Kept"]
    );
    fs::write(house.path("figures/large/report.md"), "mine").expect("a figure can be edited");
    assert_eq!(house.run().old()[2], "large/report.md KeptEdited");
    let due = Due::new(&house.pipeline, &["small".to_owned()]);
    let remove = |is_dry| {
        house
            .with_set(|set| remove_leftovers(&due, set, is_dry))
            .expect("leftovers can be removed")
    };
    let files = |names: &[&str]| names.iter().map(|name| (*name).to_owned()).collect::<Vec<_>>();
    let ours = files(&["large/pinned.csv", "large/report.csv"]);
    let edited = files(&["large/report.md"]);
    assert_eq!(remove(true), (ours.clone(), edited.clone()));
    assert!(house.path("figures/large/report.csv").exists());
    assert_eq!(remove(false), (ours, edited.clone()));
    assert_eq!(remove(false), (Vec::new(), edited));
    assert_eq!(text(&house.path("figures/large/report.md")), "mine");
    fs::remove_dir_all(house.path("figures/large")).expect("the folder can be deleted");
    assert_eq!(house.run().old(), NOTHING);
}

#[test]
fn a_failed_output_leaves_no_old_file_beside_new_ones_unnamed() {
    let mut house = House::lived_in(&[]);
    let graph = house.graph(&[]).expect("the parameters are in order");
    let scales = ["small".to_owned(), "large".to_owned()];
    let layout = publish::layout(&graph, SCALE, &scales);
    let store = house.store();
    let run = Run::new(&graph, &store, &|_: &Event| {});
    // Only `pinned` was made: `report` failed.
    let texts = BTreeMap::from([("pinned.csv".to_owned(), "new".to_owned())]);
    let due = Due::new(&house.pipeline, &scales).exactly(&run, &layout, &texts, |_| true);
    let heard = std::sync::Mutex::new(Vec::new());
    let listener = |event: &Event| {
        if let Event::DidFindOld { path, .. } = event {
            heard.lock().expect("no panic").push(path.clone());
        }
    };
    let run = Run::new(&graph, &store, &listener);
    house
        .with_set(|set| publish(&run, &texts, &due, set))
        .expect("it can be published");
    let heard = heard.into_inner().expect("no panic");
    assert_eq!(
        heard,
        [
            "large/pinned.csv",
            "large/report.csv",
            "large/report.md",
            "report.csv",
            "report.md"
        ]
    );
    house.edits.clear();
    drop(store);
    assert_eq!(house.run().old(), NOTHING);
}

#[test]
fn a_set_of_other_parameters_takes_the_whole_place_of_the_one_before() {
    let mut house = House::new();
    house.parameters = Some("[pinned]\nitem = 3\n".to_owned());
    house.run().expect_success();
    let parameters = house.path("figures/parameters.toml");
    assert_eq!(text(&parameters), "[pinned]\nitem = 3\n");
    assert_eq!((house.run().written(), house.run().old()), (Vec::new(), Vec::new()));
    fs::write(house.path("figures/large/report.md"), "mine").expect("a figure can be edited");
    house.set("pinned.item=4");
    house.parameters = Some("[pinned]\nitem = 4\n".to_owned());
    let done = house.run_targets(&["pinned"]);
    assert_eq!(done.written(), ["large/pinned.csv", "pinned.csv"]);
    assert_eq!(
        done.old(),
        [
            "large/report.csv Removed",
            "large/report.md KeptEdited",
            "report.csv Removed",
            "report.md Removed"
        ]
    );
    assert_eq!(text(&parameters), "[pinned]\nitem = 4\n");
    assert!(!house.path("figures/report.csv").exists());
}

#[test]
fn a_named_set_is_not_replaced_unless_that_is_asked_for() {
    let mut house = House::new();
    house.parameters = Some("one = 1\n".to_owned());
    house.may_replace = false;
    house.run().expect_success();
    house.run().expect_success();
    let before: Vec<String> = house.files_in("figures").iter().map(|path| text(path)).collect();
    house.set("pinned.item=4");
    house.parameters = Some("one = 2\n".to_owned());
    let error = house.run().outcome.expect_err("the name is taken");
    assert_eq!(error.exit_code(), 2);
    assert!(
        error.to_string().contains("choose another --name, or add --replace"),
        "{error}"
    );
    let after: Vec<String> = house.files_in("figures").iter().map(|path| text(path)).collect();
    assert_eq!(after, before);
    house.may_replace = true;
    house.run().expect_success();
    assert_eq!(text(&house.path("figures/parameters.toml")), "one = 2\n");
}

#[test]
fn two_runs_at_once_into_one_folder_leave_one_set() {
    let house = House::lived_in(&[]);
    let all = [
        "pinned.csv",
        "report.csv",
        "report.md",
        "large/pinned.csv",
        "large/report.csv",
    ];
    for round in 0..20 {
        std::thread::scope(|scope| {
            for one in 0..4 {
                let (house, own) = (&house, format!("{round} {one}"));
                scope.spawn(move || {
                    let texts = all.map(|name| (name, own.as_str()));
                    published(house, &texts).expect("it can be published");
                });
            }
        });
        let found: std::collections::BTreeSet<String> =
            all.iter().map(|name| text(&house.path("figures").join(name))).collect();
        assert_eq!(found.len(), 1, "{found:?}");
    }
    // None of them forgot what another had published.
    let lines = text(&house.path("artifacts/published"));
    assert_eq!(lines.lines().count(), 6 + 20 * 4 * all.len());
    house.run().expect_success();
    assert_eq!(house.run().set_aside(), NOTHING);
}

#[test]
fn the_name_of_a_what_if_is_a_folder_and_nothing_else() {
    let profiles = ["paper", "quick", "tiny"];
    let long = "x".repeat(64);
    for name in ["heavy", "a", "2_0-b", "whatif-00000000", long.as_str()] {
        assert_eq!(check_name(name, &profiles), Ok(()));
    }
    let longer = "x".repeat(65);
    for name in [
        "", ".", "..", "a/b", "../a", "a b", "a.lock", "quick", "Paper", "TINY", "-a", "a\\b", "\u{e9}", "a\n", &longer,
    ] {
        let refusal = check_name(name, &profiles).expect_err(name);
        assert!(refusal.contains("expected"), "{refusal}");
    }
}

#[test]
fn the_same_difference_from_the_profile_has_the_same_name_however_it_is_written() {
    let params = |sets: &[&str]| {
        let mut params = ParamsFile::default();
        params
            .layer("base.toml", "[sea.S1]\nheight = 12.0\nbins = 7\nlist = [1, 2]\n")
            .expect("the parameters are TOML");
        for set in sets {
            params.set(set).expect("an assignment");
        }
        params
    };
    let base = params(&[]);
    let name = |sets: &[&str]| derived_name(&params(sets), &base, "paper");
    let one = name(&["sea.S1.height=13"]);
    assert!(one.starts_with("whatif-") && one.len() == 15, "{one}");
    for same in [
        &["sea.S1.height=13.0"] as &[&str],
        &["sea.S1.height=13.00", "sea.S1.bins=7"],
        &["sea.S1.height=1", "sea.S1.height=1.3e1"],
    ] {
        assert_eq!(name(same), one, "{same:?}");
    }
    for other in [
        &["sea.S1.height=13.5"] as &[&str],
        &["sea.S1.bins=13"],
        &["sea.S1.height=13", "sea.S1.bins=8"],
        &["sea.S1.list=[1, 3]"],
        &["sea.S1.list=[1]"],
        &[],
    ] {
        assert_ne!(name(other), one, "{other:?}");
    }
    // A quick what-if is not the paper's.
    let quick = derived_name(&params(&["sea.S1.height=13"]), &base, "quick");
    assert_ne!(quick, one);
}

#[test]
fn a_checkout_that_is_moved_knows_its_figures() {
    let house = House::lived_in(&[]);
    let moved = tempfile::tempdir().expect("a temporary folder can be made");
    for name in ["figures", "artifacts", "store"] {
        fs::rename(house.path(name), moved.path().join(name)).expect("a folder can be moved");
    }
    let mut house = House::at(moved.path());
    assert_eq!(house.checkout().artifacts(), Checkout::at(moved.path()).artifacts());
    house.set("run.scales=[\"small\"]");
    assert_eq!(house.run().old().len(), 3);
}
