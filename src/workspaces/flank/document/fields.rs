//! Every parameter of a flank. Forms, `--set`, reports and the names of steps of undo are made from this table.

use super::FlankDocument;
use files::{Field, FieldTable, Group, Variant, When, Word, word};
use import::Units;

const SOURCES: &[Variant] = &[
    Variant {
        word: word("demonstration", "demonstration", "A surface that comes with the program"),
        new: "{ kind = \"demonstration\", surface = \"a\" }",
    },
    Variant {
        word: word("guides", "two guide curves", "Points of both curves in CSV files"),
        new: "{ kind = \"guides\", lower = { file = \"lower.csv\" }, upper = { file = \"upper.csv\" } }",
    },
    Variant {
        word: word("mesh", "face of a part", "A face of a mesh"),
        new: "{ kind = \"mesh\", file = \"part.stl\" }",
    },
];
const SURFACES: &[Word] = &[word("a", "A", "Surface A of the paper"), word("b", "B", "Surface B of the paper")];
const SIDES: &[Word] = &[
    word("automatic", "auto", "Outside of the part; of a demonstration the side of its paper; two guides need another"),
    word("positive", "+1", "Where the lower guide crossed with the ruling points to"),
    word("negative", "\u{2212}1", "The other side"),
];
const HOLDER: &[Field] = &[
    Field::number("length_mm", "Length", "mm", 1e-3, 1e4).symbol("length").step(0.1).help("Length along the axis."),
    Field::number("lower_radius_mm", "R below", "mm", 0.0, 1e4).step(0.02).help("Radius of the lower end."),
    Field::number("upper_radius_mm", "R above", "mm", 0.0, 1e4).step(0.02).help("Radius of the upper end."),
];
const OFFSETS: &[Word] = &[
    word("two-point", "two-point", "The cutter touches both guides at the same u"),
    word("three-point", "three-point", "It touches both guides and the middle of the surface"),
];
const OBJECTIVES: &[Variant] = &[
    Variant {
        word: word("sum", "sum", "Total absolute deviation; the greatest deviations may grow"),
        new: "{ least = \"sum\" }",
    },
    Variant { word: word("rms", "rms", "Root mean square of the deviations"), new: "{ least = \"rms\" }" },
    Variant {
        word: word("bounded", "bounded", "Total absolute deviation, with bounds of overcut and undercut"),
        new: "{ least = \"bounded\", overcut_mm = 0.01 }",
    },
];
const ROWS: &[Word] = &[
    word("shift", "shift", "Shift along the normal, as in the paper"),
    word("height", "and height", "And the height along a cone, which changes its radius"),
    word("moving", "exact", "And another place of the axis over the sample: the exact derivative"),
];
const SUMS: &[Word] = &[
    word("surface", "surface", "The grid of the design surface"),
    word("axis", "axis surface", "An even grid over t and a, as in the paper: also less where a path leaves the part"),
];
const PATHS: &[Word] = &[
    word("initial", "initial", "Mill the initial path (offset)"),
    word("chosen", "chosen", "Mill the chosen path (best rank)"),
    word("refined", "refined", "Mill the refined path"),
];
const CUTS: &[Word] = &[
    word("climb", "climb", "The surface to the right of the travel, with the spindle clockwise"),
    word("conventional", "conventional", "The surface to the left of the travel, with the spindle clockwise"),
];
const TIPS: &[Word] = &[
    word("off", "axes", "Positions of the machine's axes: the control needs no knowledge of the machine"),
    word(
        "angles",
        "tip, angles",
        "The tool's tip with the rotary axes (G43.4 on many controls): the post must have the word, as milling-tcp has",
    ),
    word(
        "vector",
        "tip, direction",
        "The tool's tip with its direction (G43.5 on many controls): the post must have the word, as milling-tcp has",
    ),
];
const NO_MACHINE: &[Word] = &[word("", "none", "Cutter locations only")];
const POSTS: &[Word] = &[
    word("milling", "milling", ""),
    word("milling-tcp", "milling-tcp", ""),
    word("iso", "iso", ""),
    word("beckhoff-edm", "beckhoff-edm", ""),
];
const DEMONSTRATION: When = When::Is("source.kind", &["demonstration"]);
const GUIDES: When = When::Is("source.kind", &["guides"]);
const MESH: When = When::Is("source.kind", &["mesh"]);
const BOUNDED: When = When::Is("plan.objective.least", &["bounded"]);
const CLAMPED: When = When::IsNot("milling.workpiece", &[""]);

/// Every parameter of a flank.
pub static FIELDS: FieldTable<FlankDocument> = FieldTable::new(&[
    Group {
        section: "Surface",
        name: "Surface",
        is_folded: false,
        fields: &[
            Field::variant("source", "From", "kind", SOURCES).help("Where the surface comes from."),
            Field::choice("source.surface", "Surface", SURFACES)
                .when(DEMONSTRATION)
                .help("A surface of the paper that the method is from."),
            Field::file("source.lower.file", "Lower")
                .when(GUIDES)
                .help("Points of the lower curve: x, y, z in mm on each line of a CSV file."),
            Field::file("source.upper.file", "Upper")
                .when(GUIDES)
                .help("Points of the upper curve: x, y, z in mm on each line of a CSV file."),
            Field::file("source.file", "Part").when(MESH).help("The mesh with the flank."),
            Field::choice("source.units", "Unit of the part", Units::WORDS).when(MESH).help("Unit of the mesh."),
            Field::integer("source.candidate", "Face", 1.0, 1e6)
                .when(MESH)
                .help("Which of the faces that could be milled, by area, from 1."),
            Field::direction("source.fit.up", "Up").when(MESH).help(
                "Along the cutter's axis to the spindle, in the axes of the part: from the lower guide to the upper.",
            ),
            Field::number("source.fit.tolerance_mm", "Ruled to", "mm", 1e-9, f64::INFINITY)
                .decimals(4)
                .step(0.001)
                .when(MESH)
                .help("Greatest distance between the face and the ruled surface that it is said to be."),
            Field::flag("source.is_own_wall", "Rest must not be cut")
                .when(MESH)
                .help("Flutes and holder are checked against the part's other faces."),
            Field::choice("side", "Side", SIDES).help("On which side of the surface the cutter stands."),
        ],
    },
    Group {
        section: "Cutter",
        name: "",
        is_folded: false,
        fields: &[
            Field::text("cutter.name", "Name").help("Name of the cutter in programs and reports; may be empty."),
            Field::number("cutter.radius_mm", "Radius", "mm", 1e-3, 1e4)
                .symbol("r0")
                .slider(0.1, 6.0)
                .step(0.02)
                .help("Radius of the cutter's bottom circle."),
            Field::number("cutter.taper_deg", "Taper", "deg", 0.0, 45.0)
                .symbol("\u{3b1}")
                .slider(0.0, 20.0)
                .step(0.05)
                .help("Angle between axis and flute: 0 for a cylinder."),
            Field::number("cutter.length_mm", "Flutes", "mm", 1e-3, 1e4)
                .slider(2.0, 80.0)
                .decimals(2)
                .step(0.1)
                .help("Length of the flutes along the axis."),
            Field::rows(
                "cutter.holder",
                "Shank and holder",
                HOLDER,
                "{ length_mm = 20.0, lower_radius_mm = 4.0, upper_radius_mm = 4.0 }",
            )
            .help("What is above the flutes, from below upwards: checked against walls."),
        ],
    },
    Group {
        section: "Path",
        name: "",
        is_folded: false,
        fields: &[
            Field::choice("plan.offset", "Offset", OFFSETS).help("How the cutter is placed first."),
            Field::integer("plan.locations", "Locations", 4.0, 10_000.0)
                .symbol("m")
                .help("Cutter locations of the initial path."),
            Field::integer("plan.control_points", "Points", 4.0, 100.0).help(
                "Control points of each of the two curves of the axis surface; around a ring as many more as it needs.",
            ),
            Field::numbers("plan.grid", "Grid", "", 2.0, 1e6)
                .whole()
                .count(2)
                .help("Samples along the guides and along the rulings; all sums are over these."),
            Field::variant("plan.objective", "Minimise", "least", OBJECTIVES).help("What the refined path minimises."),
            Field::number("plan.objective.overcut_mm", "Overcut bound", "mm", 0.0, f64::INFINITY)
                .or_nothing(0.01)
                .step(0.001)
                .when(BOUNDED)
                .help("Greatest depth that may be cut below the surface; 0 for no overcut."),
            Field::number("plan.objective.undercut_mm", "Undercut bound", "mm", 0.0, f64::INFINITY)
                .or_nothing(0.01)
                .step(0.001)
                .when(BOUNDED)
                .help("Greatest stock that may be left on the surface."),
            Field::integer("plan.rounds", "Iterations", 0.0, 10_000.0)
                .help("Greatest number of iterations of the refinement; 0 for none."),
            Field::number("plan.below_mm", "Extend below", "mm", 0.0, 100.0)
                .step(0.02)
                .help("Distance by which the cutter's bottom extends below the lower guide, along its axis."),
            Field::flag("plan.is_covering", "Cover the whole surface")
                .help("Extend the path past the ends of the guides until the whole surface is covered."),
            Field::choice("path", "Path", PATHS).help("Which path is milled."),
        ],
    },
    Group {
        section: "Path",
        name: "Fine points",
        is_folded: true,
        fields: &[
            Field::number("plan.overrun_u", "Overrun", "", 0.0, 0.1)
                .help("How far past the last place needed the path goes, as a share of the guides."),
            Field::number("plan.slide_u", "Slide", "", 1e-3, 0.5)
                .help("How far the upper contact may slide away from the lower one, as a share of the guides."),
            Field::choice("plan.row", "Matrix row", ROWS)
                .help("How a change of the control points is taken to change the deviation, for the chosen path."),
            Field::choice("plan.sum", "Sum over", SUMS)
                .help("The grid over which the deviations of each rank are summed to choose the path."),
            Field::integer("source.fit.most_control_points", "Points of a guide", 7.0, 259.0)
                .when(MESH)
                .help("Control points that each fitted guide may have at most."),
        ],
    },
    Group {
        section: "Walls",
        name: "",
        is_folded: false,
        fields: &[
            Field::file("walls.file", "Mesh of walls")
                .help("Walls beside the flank that neither flutes nor holder may touch."),
            Field::choice("walls.units", "Unit of the walls", Units::WORDS)
                .when(When::IsNot("walls", &[""]))
                .help("Unit of the walls."),
        ],
    },
    Group {
        section: "Checks",
        name: "",
        is_folded: false,
        fields: &[
            Field::number("plan.gouge_tolerance_mm", "Gouge to", "mm", 0.0, 1.0)
                .step(0.001)
                .help("Depth in neighbouring walls that does not count as a gouge."),
            Field::number("envelope_tolerance_mm", "Envelope to", "mm", 1e-6, 1.0)
                .step(0.0005)
                .help("Greatest difference of swept envelope and static deviation at any sample."),
            Field::number("overcut_tolerance_mm", "Overcut to", "mm", 1e-6, 1.0)
                .step(0.001)
                .help("Greatest overcut, static or of the swept envelope."),
            Field::number("undercut_tolerance_mm", "Undercut to", "mm", 1e-6, 1.0)
                .step(0.001)
                .help("Greatest undercut, static or of the swept envelope."),
        ],
    },
    Group {
        section: "Machine",
        name: "Machine",
        is_folded: false,
        fields: &[Field::choice_or_file("milling.machine", "Machine", NO_MACHINE)
            .help("The five-axis machine: a name, a TOML file, or one of several in such a file as FILE.toml#NAME.")],
    },
    Group {
        section: "Machine",
        name: "Clamping",
        is_folded: false,
        fields: &[
            Field::numbers("milling.workpiece.zero_mm", "Zero", "mm", -1e6, 1e6)
                .count(3)
                .when(CLAMPED)
                .help("The workpiece's zero in machine coordinates."),
            Field::direction("milling.workpiece.z_axis", "Its Z along").when(CLAMPED).help(
                "The machine's direction along which the workpiece's Z points: \u{2212}Z if it is clamped upside down.",
            ),
            Field::direction("milling.workpiece.x_axis", "Its X along")
                .when(CLAMPED)
                .help("The machine's direction along which the workpiece's X points; its share along Z is removed."),
        ],
    },
    Group {
        section: "Machine",
        name: "Program",
        is_folded: false,
        fields: &[
            Field::choice_or_file("milling.post", "Post", POSTS).help("The control for which the program is written."),
            Field::choice("milling.program.tip_control", "X Y Z are", TIPS).help("Meaning of X Y Z in a program."),
            Field::integer("milling.program.tool_number", "Tool number", 0.0, 99_999.0)
                .when(When::IsNot("milling.program.tip_control", &["off"]))
                .help("Number of the tool's length offset, written as H."),
            Field::number("milling.gauge_length_mm", "Gauge length", "mm", 0.0, 1e4)
                .or_nothing(100.0)
                .decimals(2)
                .step(0.1)
                .when(When::IsNot("milling.machine", &[""]))
                .help("From the spindle nose to the tip; otherwise as the machine's file says."),
            Field::choice("milling.cut", "Cut", CUTS).help("How rotation and travel of the cutter go together."),
            Field::number("milling.linearisation_mm", "Tolerance", "mm", 1e-4, 1.0)
                .decimals(4)
                .step(0.0005)
                .help("Chordal deviation of tip and flutes' top between programmed points."),
            Field::number("milling.program.feed_mm_per_min", "Feed", "mm/min", 0.001, 1e5)
                .decimals(1)
                .step(5.0)
                .help("Feed of the cut along the flank."),
            Field::number("milling.program.lead_mm_per_min", "Lead feed", "mm/min", 0.001, 1e5)
                .decimals(1)
                .step(5.0)
                .help("Feed of approach and retraction."),
            Field::number("milling.program.spindle_rpm", "Spindle", "1/min", 1.0, 1e6)
                .decimals(0)
                .step(50.0)
                .help("Speed of the spindle."),
            Field::number("milling.aside_mm", "Lead-in", "mm", 0.0, 1000.0)
                .step(0.02)
                .help("Length of lead-in and lead-out from the side, at both ends of the path."),
            Field::number("milling.retract_mm", "Retract distance", "mm", 0.0, 1000.0)
                .decimals(2)
                .step(0.2)
                .help("Retract distance along the cutter axis at both ends."),
            Field::number("milling.singular_cone_deg", "Pole angle", "deg", 0.0, 20.0)
                .help("Passing the machine's pole within this angle is reported."),
        ],
    },
]);

/// Name of the step from `before` to `now`, for undo.
pub fn change(before: &FlankDocument, now: &FlankDocument) -> String {
    if let Some(new) = now.overrides.iter().find(|one| !before.overrides.contains(one)) {
        return format!("Override of {}", new.check);
    }
    match () {
        () if now.overrides != before.overrides => "Override taken back".to_owned(),
        () if now.source != before.source && now.side != before.side => "Surface".to_owned(),
        // What was of the former machine goes with it.
        () if now.milling.machine != before.milling.machine => "Machine".to_owned(),
        () => FIELDS.change(before, now),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::workspaces::flank::document::{FlankSource, MeshFlank};
    use crate::workspaces::says_labels;
    use files::{Override, Validate};
    use flank::cutter::HolderPart;
    use nc::flank_program::milling_posts;

    #[test]
    fn the_table_is_sound() {
        let mut document = FIELDS.set(&FlankDocument::default(), "walls.file", "walls.stl").unwrap();
        document.milling.workpiece = Some(Default::default());
        assert_eq!(FIELDS.audit(&document, |p| p.validate().is_ok()), Vec::<String>::new());
        assert_eq!(POSTS.iter().map(|post| post.word).collect::<Vec<_>>(), milling_posts());
    }

    #[test]
    fn the_window_says_no_key_of_any_parameter_out_of_its_range() {
        let mut document = FlankDocument::default();
        document.cutter.holder = vec![HolderPart { length_mm: 1.0, lower_radius_mm: 2.0, upper_radius_mm: 3.0 }];
        document.milling.workpiece = Some(Default::default());
        let mesh = FlankSource::Mesh(MeshFlank::of("part.stl".as_ref()));
        let of_mesh = FlankDocument { source: mesh, ..document.clone() };
        let beyond: Vec<_> = [&document, &of_mesh].into_iter().flat_map(|d| FIELDS.beyond(d)).collect();
        assert!(beyond.len() > 80, "{}", beyond.len());
        says_labels(&FIELDS, beyond);
        // What does not go together is said in these words, too.
        for (edit, words) in [
            ((|d| d.plan.below_mm = 40.0) as fn(&mut FlankDocument), "Extend below is 40 mm: must be less than"),
            (|d| d.plan.locations = 6, "Locations is 6: must be"),
            (|d| d.plan.grid = [4, 4], "Grid is 16: must be"),
            (|d| (d.cutter.length_mm, d.plan.below_mm) = (2000.0, 0.0), "Flutes"),
            (|d| d.milling.post = "none.toml".to_owned(), "Post"),
        ] {
            let mut wrong = FlankDocument::default();
            edit(&mut wrong);
            let said = FIELDS.in_window(&wrong.validate().unwrap_err());
            assert!(said.starts_with(words) && !said.contains('_'), "{said}");
        }
    }

    #[test]
    fn a_step_is_called_after_what_was_changed() {
        let before = FlankDocument::default();
        for (name, edit) in [
            ("Surface", (|d| *d = FIELDS.set(d, "source.surface", "b").unwrap()) as fn(&mut FlankDocument)),
            ("Radius", |d| d.cutter.radius_mm = 2.0),
            ("Name", |d| d.cutter.name.push('x')),
            ("Grid", |d| d.plan.grid = [50, 20]),
            ("Iterations", |d| d.plan.rounds = 3),
            ("Machine", |d| (d.milling.machine, d.milling.gauge_length_mm) = (String::new(), Some(1.0))),
            ("Feed", |d| d.milling.program.feed_mm_per_min = 1.0),
            ("Envelope to", |d| d.envelope_tolerance_mm = 0.01),
            ("Override of gouge", |d| d.overrides.push(Override::whatever("gouge"))),
            ("", |_| ()),
        ] {
            let mut after = before.clone();
            edit(&mut after);
            assert_eq!(change(&before, &after), name);
        }
    }

    #[test]
    fn parameters_are_set_by_their_keys() {
        let set = |key: &str, text: &str| FIELDS.set(&FlankDocument::default(), key, text);
        let clamped = set("milling.workpiece.z_axis", "-z").unwrap().milling.workpiece.unwrap();
        assert_eq!(clamped.z_axis, glam::DVec3::NEG_Z);
        assert_eq!(set("milling.workpiece.x_axis", "0,1,0").unwrap().milling.workpiece.unwrap().x_axis, glam::DVec3::Y);
        let walled = set("walls.file", "walls.stl").unwrap();
        assert_eq!(walled.walls.as_ref().unwrap().file, std::path::Path::new("walls.stl"));
        assert_eq!(FIELDS.set(&walled, "walls.file", "none").unwrap().walls, None);
        assert_eq!(set("plan.grid", "60x30").unwrap().plan.grid, [60, 30]);
        assert!(set("source.candidate", "2").is_err(), "a demonstration has no faces");
        let mesh = FIELDS.set(&set("source", "mesh").unwrap(), "source.file", "a.stl").unwrap();
        assert_eq!(mesh.source, FlankSource::Mesh(MeshFlank::of("a.stl".as_ref())));
    }
}
