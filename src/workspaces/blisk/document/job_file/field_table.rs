//! Every parameter of a blisk's plan. Forms, `--set`, reports and the names of steps of undo are made from this table.

use files::{Field, FieldTable, Group, When};

use super::blade_fields::BLADES;
use super::choice_words::{
    AXES, AXIS_WORDS, BODIES, CHANNELS, CONSTRAINTS, CURVES, END_WALLS, ENDS, FACES, FRAMES, H_MODES, HEADS,
    JOB_SHEETS, MACHINES, POSTS, SIDES, SIZES, STRATEGIES, TURNED, UNITS, Z_AT,
};
use super::electrode_fields::{OWN_ELECTRODE, SINGLE_PARTS, STAGES};
use super::scan_fields::SCAN;
use super::setting_fields::SETTING;
use super::setup_fields::{PRESETS, SETUP};
use super::technology_fields::{BURNING, TECHNOLOGY};
use super::weight_fields::WEIGHTS;
use super::{BladesFrom, PlanJob};

/// A greatest value that is none.
const ANY: f64 = f64::INFINITY;
/// What the thresholds of single sides mean.
const SIDE: &str = "Least distance wanted of this side of the electrode, as far as 0.05 mm for each mm withdrawn from the \
    final pose; 0: spark gap and margin alone.";

/// The parameters in the order of the forms, under the steps that they belong to.
pub static FIELDS: FieldTable<PlanJob> = FieldTable::new(GROUPS).with_defaults(defaults);

/// The defaults of the same part.
fn defaults(job: &PlanJob) -> PlanJob {
    match &job.blisk.mesh {
        Some(mesh) => PlanJob::for_mesh(mesh),
        None if job.blisk.sections != BladesFrom::None => PlanJob::of_blades(job.blisk.sections.with_defaults()),
        None => PlanJob::demonstration(),
    }
}

const GROUPS: &[Group] = &[
    Group {
        section: "Part",
        name: "Mesh",
        is_folded: false,
        fields: &[
            Field::choice("blisk.units", "Unit", UNITS).help(
                "Unit of the mesh file. Automatic goes by the file and by its size; the reason is shown \
                 below.",
            ),
        ],
    },
    Group {
        section: "Part",
        name: "STEP file",
        is_folded: true,
        fields: &[
            Field::numbers("blisk.solids", "Solids", "", 1.0, 10_000.0).whole().help(
                "Numbers of the solids of a STEP file that make the blisk. None for the largest that is no obstacle and \
                 all that lie beside it. Those that touch are united.",
            ),
            Field::numbers("blisk.obstacles", "Obstacles", "", 1.0, 10_000.0).whole().help(
                "Numbers of the solids of a STEP file that are in the way: a fixture, or a part beside it. Electrodes and their paths keep clear of them as of the blisk.",
            ),
            Field::number("blisk.step_tolerance_mm", "STEP tolerance", "mm", 1e-4, 1.0).step(0.001).help(
                "Greatest distance of the triangles from the exact faces of a STEP file: a twentieth of the spark \
                 gap is fine enough.",
            ),
        ],
    },
    BLADES,
    Group {
        section: "Channel",
        name: "Blisk",
        is_folded: false,
        fields: &[
            Field::choice_or("blisk.axis", "Axis", AXES, "{ direction = [0, 0, 1], point = [0, 0, 0] }")
                .symbol("X")
                .help(
                    "The blisk's axis in the coordinates of the mesh. It becomes the X axis of the workpiece \
                     frame W. Found from the mesh, along an axis of the mesh at the place that suits best, or a line \
                     that is given by its direction and a point of it.",
                ),
            Field::direction("blisk.axis.direction", "Direction of axis")
                .when(When::IsNot("blisk.axis", AXIS_WORDS))
                .help("Direction of the blisk's axis in the coordinates of the mesh."),
            Field::numbers("blisk.axis.point", "Point on axis", "mm", -1e6, 1e6)
                .count(3)
                .when(When::IsNot("blisk.axis", AXIS_WORDS))
                .help("A point of the blisk's axis in the coordinates of the mesh."),
            Field::integer("blisk.blades", "Blades", 2.0, 1000.0)
                .or_word("auto", 60.0)
                .help("Number of blades around the axis."),
            Field::integer("blisk.channel", "Channel", 0.0, ANY).help(
                "Which channel: 0 is the one nearest to the mesh's +Z, the others follow in the sense of a \
                 right-handed turn about X.",
            ),
            Field::choice("blisk.z_at", "Z at", Z_AT)
                .help("What of a passage that is not axial lies along Z of W, so that electrodes leave it there along Z."),
        ],
    },
    Group {
        section: "Channel",
        name: "Radii",
        is_folded: true,
        fields: &[
            Field::number("blisk.hub_radius_mm", "Hub radius", "mm", 1e-6, ANY)
                .or_word("auto", 100.0)
                .symbol("R_h")
                .help("Radius of the hub along the whole channel; found from the mesh unless given."),
            Field::number("blisk.shroud_radius_mm", "Shroud radius", "mm", 1e-6, ANY)
                .or_word("auto", 125.0)
                .symbol("R_c")
                .help(
                    "Radius of the shroud, or of the blade tips, along the whole channel; found from the mesh \
                     unless given.",
                ),
        ],
    },
    Group {
        section: "Channel",
        name: "By hand",
        is_folded: true,
        fields: &[
            Field::points("blisk.hub_points_mm", "Points on hub", "mm", -1e6, 1e6).help(
                "At least two points on the hub, in any order and at any angle about the axis, in the coordinates of \
                 the mesh. They tell which surface is the hub; it is measured beside the curve through them.",
            ),
            Field::points("blisk.shroud_points_mm", "Points on shroud", "mm", -1e6, 1e6).help(
                "At least two points on the shroud, or on the blade tips of a wheel without one, in the coordinates of \
                 the mesh.",
            ),
            Field::choice("blisk.end_walls", "Points stand for", END_WALLS).help(
                "What the points on hub and shroud stand for: the surfaces that they lie on, or curves that bound the \
                 passage themselves, above where blades grow together at the hub, say. What lies beyond a drawn curve is \
                 not burned.",
            ),
            Field::points("blisk.blade_points_mm", "Points on blades", "mm", -1e6, 1e6).help(
                "Points on walls of blades, in the coordinates of the mesh. They tell where the blades are; the wall \
                 of the first one bounds channel 0.",
            ),
        ],
    },
    Group {
        section: "Channel",
        name: "Wall grid",
        is_folded: true,
        fields: &[
            Field::integer("blisk.wall_points_chord", "Points along chord", 5.0, 300.0)
                .symbol("n_u")
                .help("Points of a channel wall from edge to edge."),
            Field::integer("blisk.wall_points_span", "Points across", 5.0, 300.0)
                .symbol("n_v")
                .help("Points of a channel wall from hub to shroud."),
        ],
    },
    Group {
        section: "Electrode",
        name: "Size",
        is_folded: false,
        fields: &[
            Field::number("electrode.spark_gap_mm", "Spark gap", "mm", 0.005, 2.0)
                .slider(0.02, 0.4)
                .symbol("g")
                // Every stage has a gap of its own.
                .when(When::Is("electrode.stage", &[""]))
                .help(
                    "Distance between the burning faces and the finished blisk in the final pose; the path \
                     keeps it all the way.",
                ),
            Field::number("electrode.circumferential_reduction_deg[0]", "Reduction, low wall", "deg", 0.0, 45.0)
                .slider(0.0, 4.0)
                .symbol("h")
                .help(
                    "Angle by which this side of the electrode is turned about X away from its wall. A larger \
                     angle gives more clearance and leaves more stock for the copying motion.",
                ),
            Field::number("electrode.circumferential_reduction_deg[1]", "Reduction, high wall", "deg", 0.0, 45.0)
                .slider(0.0, 4.0)
                .symbol("h")
                .help("Angle by which this side of the electrode is turned about X away from its wall."),
            Field::number("electrode.radial_reduction_mm", "Radial reduction", "mm", 0.0, 100.0)
                .slider(0.0, 3.0)
                .help("Distance by which the shroud side is drawn in towards the hub."),
        ],
    },
    Group {
        section: "Electrode",
        name: "Entry",
        is_folded: false,
        fields: &[
            Field::choice("electrode.enter", "Enter from", SIDES)
                .help("Side of the blisk, in W, from which the electrode enters and to which it is retracted."),
            Field::integer("electrode.parts", "Parts", 1.0, 20.0)
                .help("Number of electrodes along the passage."),
            Field::number("electrode.overlap_mm", "Overlap", "mm", 0.0, 100.0).decimals(2).help(
                "Overlap along the passage of the burns of two neighbouring parts, spark gaps included; with 0 they \
                 only meet.",
            ),
            Field::integer("electrode.columns", "Columns", 1.0, 2.0).help(
                "2 splits every part left and right along the middle surface of the channel; each electrode \
                 burns one wall.",
            ),
            Field::number("electrode.column_overlap_mm", "Column overlap", "mm", -20.0, 20.0).decimals(2).help(
                "Overlap along the circumference of the burns of the two columns, spark gaps included; a \
                 negative value leaves a web.",
            ),
            Field::number("electrode.column_split", "Column split", "", 0.1, 0.9)
                .or_word("auto", 0.5)
                .slider(0.1, 0.9)
                .decimals(2)
                .help("Share of the channel's width that belongs to the low column; auto: both are equally thick."),
        ],
    },
    SINGLE_PARTS,
    STAGES,
    Group {
        section: "Electrode",
        name: "Body",
        is_folded: true,
        fields: &[
            Field::number("electrode.overrun_mm", "Overrun", "mm", 0.0, 100.0).decimals(2).help(
                "How far the burning part reaches past the tips of the blades' edges, at most to \
                 where the passage ends.",
            ),
            Field::number("electrode.shank_inset_mm", "Shank inset", "mm", 0.02, 20.0)
                .decimals(2)
                .help("How much smaller than the burning part the shank is all round."),
            Field::number("electrode.channel_shank_inset_mm", "Inset between blades", "mm", 0.02, 20.0)
                .decimals(2)
                .help("The same for the shank of a part that stands deeper in the channel."),
            Field::number("electrode.shank_length_mm", "Shank length", "mm", 0.5, 500.0)
                .decimals(1)
                .help("How far the shank reaches out of the blisk's face, or of its rim."),
            Field::number("electrode.holder_mm[0]", "Holder length", "mm", 0.5, 500.0)
                .decimals(1)
                .help("Length of the holder block along the direction of withdrawal."),
            Field::number("electrode.holder_mm[1]", "Holder across", "mm", 0.5, 500.0)
                .decimals(1)
                .help("Width of the holder block; it grows where the shank is larger."),
            Field::number("electrode.holder_mm[2]", "Holder height", "mm", 0.5, 500.0)
                .decimals(1)
                .help("Height of the holder block, from hub to shroud; it grows where the shank is larger."),
        ],
    },
    OWN_ELECTRODE,
    Group {
        section: "Plan",
        name: "Path",
        is_folded: false,
        fields: &[
            Field::choice("plan.strategy", "Strategy", STRATEGIES).help(
                "Search for the extraction path. Global: path of greatest clearance, with the reason where \
                 there is none. Genetic: the algorithm of the papers. Centreline: along the middle of the \
                 channel. The other two are for comparison.",
            ),
            Field::number("plan.step_mm", "Step", "mm", 0.01, 10.0).decimals(2).symbol("k").help(
                "Distance between nodes along the axis of withdrawal, or along the centreline if that is followed; halved where \
                 no free pose is found.",
            ),
            Field::number("plan.exit_clearance_mm", "Exit clearance", "mm", 0.1, 200.0)
                .decimals(1)
                .help("Distance by which the electrode is retracted out of the blisk."),
            Field::number("plan.margin_mm", "Margin", "mm", 0.0, 5.0)
                .slider(0.0, 0.5)
                .help("Clearance wanted beyond the spark gap as soon as the electrode has left its final pose."),
            Field::choice("plan.constraint", "Constraint", CONSTRAINTS).help(
                "What a pose must meet during the search: the distance to the surface, or the paper's \
                 comparison of angles. The verifier has the last word either way.",
            ),
            Field::number("plan.angle.delta1_mm", "Distance of the angle test", "mm", 0.0, ANY)
                .symbol("Delta1")
                .when(When::Is("plan.constraint", &["angle"]))
                .help("Distance that the angle test keeps from hub and shroud."),
            Field::number("plan.angle.delta2_deg", "Angle of the angle test", "deg", 0.0, 90.0)
                .symbol("Delta2")
                .when(When::Is("plan.constraint", &["angle"]))
                .help("Angle that the angle test keeps."),
        ],
    },
    Group {
        section: "Plan",
        name: "Global search",
        is_folded: false,
        fields: &[
            Field::integer("plan.global.poses", "Poses", 2.0, 1000.0)
                .help("Poses kept for each node; three times as many are tried before it is given up."),
            Field::number("plan.global.room_mm", "Clearance margin", "mm", 0.0, 5.0)
                .decimals(2)
                .help("Clearance beyond the required one up to which a wider path counts as better."),
            Field::number("plan.global.room_kept", "Margin kept", "", 0.0, 1.0).slider(0.0, 1.0).decimals(2).help(
                "Share of the clearance margin that polishing keeps: 0 gives the smoothest path, 1 the \
                 widest.",
            ),
        ],
    },
    Group {
        section: "Plan",
        name: "Centreline search",
        is_folded: true,
        fields: &[Field::number("plan.centreline.safety_increase_mm", "Gap increase", "mm", 0.0, 5.0)
            .slider(0.0, 0.5)
            .help("Additional distance to the walls where the spark gap alone leads to no free motion.")],
    },
    Group {
        section: "Plan",
        name: "Distances of single sides",
        is_folded: true,
        fields: &[
            Field::number("plan.thresholds.low_wall_mm", "From low wall", "mm", 0.0, 5.0)
                .slider(0.0, 0.5)
                .help(SIDE),
            Field::number("plan.thresholds.high_wall_mm", "From high wall", "mm", 0.0, 5.0)
                .slider(0.0, 0.5)
                .help(SIDE),
            Field::number("plan.thresholds.hub_mm", "From hub", "mm", 0.0, 5.0).slider(0.0, 0.5).help(SIDE),
            Field::number("plan.thresholds.shroud_mm", "From shroud", "mm", 0.0, 5.0).slider(0.0, 0.5).help(SIDE),
        ],
    },
    Group {
        section: "Plan",
        name: "Genetic search",
        is_folded: true,
        fields: &[
            Field::integer("genetic.population", "Population", 4.0, 10000.0).help("Individuals in a generation."),
            Field::integer("genetic.generations", "Generations", 1.0, 10000.0).help("Generations for each node, at most."),
            Field::integer("genetic.stall_generations", "Stop after", 0.0, 10000.0)
                .help("Generations without a better objective after which the search of a node ends; 0: never."),
            Field::number("genetic.crossover", "Crossover", "", 0.0, 1.0)
                .slider(0.0, 1.0)
                .decimals(2)
                .symbol("k1, k3")
                .help("Probability of crossover of parents worse than average; it falls to 0 for the best."),
            Field::number("genetic.mutation", "Mutation", "", 0.0, 1.0)
                .slider(0.0, 1.0)
                .decimals(2)
                .symbol("k2, k4")
                .help(
                    "Probability that a gene of an individual worse than average mutates; it falls to 0 for the \
                     best.",
                ),
            Field::integer("genetic.elite", "Elite", 1.0, 5000.0)
                .help("Best individuals that pass unchanged, at most half the population."),
            Field::number("genetic.precision_mm", "Precision X, Y, Z", "mm", 1e-5, 0.1)
                .decimals(5)
                .help("Step of X, Y and Z in the coding of an individual (8)."),
            Field::number("genetic.precision_deg", "Precision A, B, C, h", "deg", 1e-5, 0.1)
                .decimals(5)
                .help("Step of angles in the coding of an individual (8)."),
            Field::choice("genetic.h", "Reduction h", H_MODES)
                .symbol("h")
                .help("Given: the reduction above. Search: the least additional reduction with an extraction path."),
            Field::number("genetic.h_max_deg", "Greatest h", "deg", 0.01, 20.0)
                .decimals(2)
                .help("The most that is searched for on top of the given reductions."),
            Field::integer("genetic.seed", "Seed", 0.0, ANY)
                .help("The same seed gives the same path, to the last bit."),
        ],
    },
    WEIGHTS,
    Group {
        section: "Plan",
        name: "Machine",
        is_folded: false,
        fields: &[
            Field::choice("machine.axes", "Axes", MACHINES).help("Axes that the machine moves together."),
            Field::choice_or_file("machine.name", "Bodies", BODIES).help(
                "The machine whose axes, travels and bodies count: the whole motion is simulated with its \
                 head, holder and table. A machine is a TOML file; one of your own can be chosen.",
            ),
            Field::number("machine.body_clearance_mm", "Body clearance", "mm", 0.01, 100.0)
                .decimals(2)
                .help("How far bodies of the machine stay from each other and from the blisk."),
            Field::choice_or("export.channels", "Channels", CHANNELS, "numbers as in 0,1,2").help(
                "In which channels the motion is simulated and which the NC program burns, A turning the \
                 blisk to them.",
            ),
        ],
    },
    Group {
        section: "Plan",
        name: "Fine points",
        is_folded: true,
        fields: &[
            Field::number("plan.field_cell_mm", "Field cell", "mm", 0.05, 2.0)
                .decimals(2)
                .help("Size of a cell of the distance field that the search works on."),
            Field::choice("plan.interpolation.kind", "Curve", CURVES).help(
                "What joins the nodes of each axis: cubic splines whose knots are the nodes, or NURBS with \
                 averaged knots.",
            ),
            Field::choice("plan.interpolation.ends", "Ends of splines", ENDS)
                .when(When::Is("plan.interpolation.kind", &["spline"]))
                .help("What holds at both ends of a cubic spline."),
            Field::integer("plan.interpolation.degree", "Degree of NURBS", 3.0, 5.0)
                .symbol("p")
                .help("The degree of the NURBS through the nodes; splines are cubic."),
            Field::number("plan.interpolation.chord_error_mm", "Chord error", "mm", 5e-5, 0.1).decimals(5).help(
                "How far linear motion between rows may be from the curves through the nodes, anywhere on \
                 the electrode.",
            ),
        ],
    },
    TECHNOLOGY,
    BURNING,
    Group {
        section: "Verify",
        name: "Certificate",
        is_folded: false,
        fields: &[
            Field::number("verify.tolerance_mm", "Tolerance", "mm", 0.0, 0.05)
                .decimals(4)
                .help("Accepted shortfall of the clearance below the spark gap."),
            Field::number("verify.resolution_mm", "Resolution", "mm", 1e-6, 1.0)
                .decimals(6)
                .help("How close the proven bound comes to the smallest clearance met."),
            Field::flag("verify.stop_at_violation", "Stop at violation")
                .help("Stops at the first violation without searching for others."),
        ],
    },
    SETTING,
    PRESETS,
    SCAN,
    Group {
        section: "Export",
        name: "NC program",
        is_folded: false,
        fields: &[
            Field::choice_or_file("export.post", "Post-processor", POSTS).help(
                "The words that the control understands. A post is a TOML file; one of your own can be \
                 chosen.",
            ),
            Field::number("export.nc.feed_mm_per_min", "Feed", "mm/min", 0.001, 100000.0).decimals(1).help(
                "Feed towards the final pose. While eroding, the generator's servo sets the pace; this is \
                 its limit.",
            ),
            Field::number("export.nc.retract_mm_per_min", "Retraction", "mm/min", 0.001, 100000.0)
                .decimals(1)
                .help("Feed of the approach and of the retraction."),
            Field::number("export.nc.burn_dwell_s", "Dwell", "s", 0.0, 1e6)
                .decimals(1)
                .help("Dwell in the final pose after the stop for the burn; 0 for none."),
        ],
    },
    SETUP,
    Group {
        section: "Export",
        name: "Files",
        is_folded: true,
        fields: &[
            Field::choice("export.frame", "Electrode in", FRAMES).help(
                "The frame of electrode_K.stl: that of the loaded mesh, or the workpiece frame W, whose \
                 place in the loaded mesh stands in every result.",
            ),
            Field::flag("export.files.electrode", "Electrode")
                .help("electrode_K.stl: each electrode in its final pose."),
            Field::flag("export.files.step", "Electrode as STEP").help(
                "electrode_K.step: planes, cylinders, cones and fitted B-splines in the place of triangles, in the frame of \
                 the STL file. It is written only where it keeps the clearance that the certified path needs.",
            ),
            Field::flag("export.files.path", "Path").help("path_K.csv: the rows of the motion, in W."),
            Field::flag("export.files.nc", "NC program")
                .help("path_K.nc through the post. Only a certified path has one."),
            Field::flag("export.files.report", "Report").help(
                "report.html for people, report.json for programs, and the tables of its figures: nodes_K.csv, centroid_K.csv, \
                 wall_distances_K.csv, inscribed_circles.csv, section_deviations.csv, schedule.csv, measuring_points.csv, and the job \
                 file: job.json, job.xml, job.csv, job_sheet.txt.",
            ),
            Field::choice_or_file("export.job_sheet", "Job sheet", JOB_SHEETS).help(
                "job_sheet.txt: what job.json holds as text of any form. A template (Jinja) of your own can be chosen.",
            ),
            Field::flag("export.files.leftover", "Residual stock").help(
                "leftover.ply: the surface of the channel with the residual stock at every vertex. \
                 copying_K.csv: the copying motion of each certified path.",
            ),
            Field::flag("export.files.pictures", "Pictures")
                .help("The pictures as PNG files. The page of the report holds them in any case."),
        ],
    },
    Group {
        section: "Export",
        name: "Pictures",
        is_folded: true,
        fields: &[
            Field::flag("export.pictures.whole", "Whole blisk").help("The whole blisk with its electrodes before it."),
            Field::flag("export.pictures.final_pose", "Final pose")
                .help("Each electrode in its final pose in the channel."),
            Field::flag("export.pictures.sweep", "Sweep").help("Each electrode in many poses along its path."),
            Field::flag("export.pictures.closest", "Closest point")
                .help("A section where each electrode comes closest, or jams."),
            Field::flag("export.pictures.leftover", "Residual stock")
                .help("The residual stock on the surfaces of the channel, as colours."),
        ],
    },
    // What no form shows: files and the command line alone have it.
    Group {
        section: "",
        name: "Files and command line",
        is_folded: true,
        fields: &[
            Field::file("blisk.mesh", "Blisk").help("Mesh file of the finished blisk."),
            Field::choice("electrode.size", "Size", SIZES)
                .help("Reductions as given, or the least ones for which there is an extraction path."),
            Field::choice("machine.head_along", "Head comes", HEADS).help(
                "Axis along which the head of a machine with bodies comes. Along Z it serves electrodes from the rim, \
                 along X all others. A machine's file says it.",
            ),
            Field::choice("machine.mounted_face", "Face on the table", FACES).help(
                "Face of the blisk that the table holds, where the head comes along Z. Where it comes along X it is the \
                 face away from the side of entry.",
            ),
            Field::choice("machine.c_turns", "C turns", TURNED).help(
                "Part that C turns on a machine with bodies: the electrode, or the table that carries A, as on a tilting \
                 table. A machine's file says it.",
            ),
            Field::numbers("machine.c_axis_mm", "C axis of the table", "mm", -1e4, 1e4).help(
                "Place (x, y) of the C axis in the final pose where C turns the table, counted from the blisk's axis at \
                 the face that the table holds.",
            ),
            Field::numbers("machine.travel_x_mm", "Travel of X", "mm", -ANY, ANY)
                .count(2)
                .help("Least and greatest X about the final pose."),
            Field::numbers("machine.travel_y_mm", "Travel of Y", "mm", -ANY, ANY)
                .count(2)
                .help("Least and greatest Y about the final pose."),
            Field::numbers("machine.travel_z_mm", "Travel of Z", "mm", -ANY, ANY)
                .count(2)
                .help("Least and greatest Z about the final pose."),
            Field::numbers("machine.travel_a_deg", "Travel of A", "deg", -ANY, ANY)
                .count(2)
                .help("Least and greatest A about the final pose."),
            Field::numbers("machine.travel_b_deg", "Travel of B", "deg", -ANY, ANY)
                .count(2)
                .help("Least and greatest B about the final pose."),
            Field::numbers("machine.travel_c_deg", "Travel of C", "deg", -ANY, ANY)
                .count(2)
                .help("Least and greatest C about the final pose."),
            Field::number("machine.speed_mm_min", "Speed of X, Y, Z", "mm/min", 0.0, ANY)
                .help("Greatest speed of the linear axes."),
            Field::number("machine.speed_deg_min", "Speed of A, B, C", "deg/min", 0.0, ANY)
                .help("Greatest speed of the rotary axes."),
        ],
    },
];

#[cfg(test)]
mod tests {
    use files::Validate as _;

    use super::*;

    #[test]
    fn the_table_is_sound() {
        let job = PlanJob::for_mesh("part.stl".as_ref());
        assert_eq!(FIELDS.audit(&job, |job| job.validate().is_ok()), Vec::<String>::new());
    }

    #[test]
    fn a_list_is_set_as_a_whole_and_called_by_the_labels_of_its_entries() {
        let job = PlanJob::for_mesh("part.stl".as_ref());
        let key = "electrode.circumferential_reduction_deg";
        let set = |text: &str| FIELDS.set(&job, key, text);
        assert_eq!(set("[5, 6.5]").unwrap().electrode.circumferential_reduction_deg, [5.0, 6.5]);
        assert!(set("[5]").unwrap_err().to_string().contains("must be a list of 2 values"));
        assert!(set("[5, -1]").unwrap_err().to_string().contains("circumferential_reduction_deg[1]"));
        let labelled = FIELDS.labelled("no metal is left; lower circumferential_reduction_deg");
        assert_eq!(labelled, "no metal is left; lower \"Reduction, low wall\" or \"Reduction, high wall\"");
    }

    #[test]
    fn every_number_of_a_plan_is_in_the_table() {
        fn leaves(value: &serde_json::Value, key: &str, all: &mut Vec<String>) {
            let inner = |name: &str| if key.is_empty() { name.to_owned() } else { format!("{key}.{name}") };
            match value {
                serde_json::Value::Object(table) => table.iter().for_each(|(k, v)| leaves(v, &inner(k), all)),
                _ => all.push(key.to_owned()),
            }
        }
        let mut all = Vec::new();
        leaves(&FIELDS.values(&PlanJob::demonstration()), "", &mut all);
        for key in all {
            let names = [key.clone(), format!("{key}[0]"), key.trim_end_matches(".kind").to_owned()];
            assert!(names.iter().any(|name| FIELDS.find(name).is_ok()), "{key}");
        }
    }
}
