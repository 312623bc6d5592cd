//! The table of all parameters, in the order of the forms.

use super::fields::Kind::{AutoInteger, AutoNumber, Choice, ChoiceOrFile, File, Flag, Integer, Number, Slider};
use super::fields::{Field, Kind, Range};
use super::stage::Stage;

#[allow(clippy::too_many_arguments)] // One row of a table.
const fn field(
    stage: Stage,
    group: &'static str,
    pointer: &'static str,
    label: &'static str,
    symbol: &'static str,
    unit: &'static str,
    kind: Kind,
    help: &'static str,
) -> Field {
    Field { stage, group, pointer, label, symbol, unit, kind, help }
}

const UNITS: &[(&str, &str)] =
    &[("auto", "automatic"), ("mm", "mm"), ("cm", "cm"), ("m", "m"), ("inch", "inch"), ("um", "µm")];
const AXES: &[(&str, &str)] = &[("auto", "automatic"), ("x", "X"), ("y", "Y"), ("z", "Z")];
const SIDES: &[(&str, &str)] = &[("auto", "automatic"), ("-x", "-X"), ("+x", "+X")];
const MACHINES: &[(&str, &str)] = &[("XYZC", "XYZ C"), ("XYZAC", "XYZ A C"), ("XYZABC", "XYZ A B C")];
const BODIES: &[(&str, &str)] =
    &[("", "none"), ("xyzc", "built-in XYZ C"), ("xyzac", "built-in XYZ A C"), ("xyzabc", "built-in XYZ A B C")];
const CHANNELS: &[(&str, &str)] = &[("own", "the planned one"), ("all", "all, by A")];
const CONSTRAINTS: &[(&str, &str)] = &[("distance", "distance"), ("angle", "angle")];
const STRATEGIES: &[(&str, &str)] = &[
    ("global", "global"),
    ("genetic", "genetic"),
    ("centreline", "centreline"),
    ("free-travel", "free travel"),
    ("max-min-distance", "max. min. distance"),
];
const CURVES: &[(&str, &str)] = &[("spline", "cubic spline"), ("nurbs", "NURBS")];
const H_MODES: &[(&str, &str)] = &[("given", "as given"), ("variable", "search")];
const POSTS: &[(&str, &str)] = &[("iso", "ISO / RS-274"), ("beckhoff-edm", "Beckhoff EDM")];
const FRAMES: &[(&str, &str)] = &[("mesh", "loaded mesh"), ("w", "workpiece W")];

const REDUCTION: Kind = Slider(Range(0.0, 45.0), Range(0.0, 4.0), 3);
const WEIGHT: Kind = Slider(Range(0.0, f64::INFINITY), Range(0.0, 1.0), 2);

/// Every parameter that a form shows.
#[rustfmt::skip]
pub(super) const FIELDS: &[Field] = &[
    field(Stage::Part, "Mesh", "/blisk/units", "Unit", "", "", Choice(UNITS), "Unit of the mesh file. Automatic goes by the file and by its size; the reason is shown below."),

    field(Stage::Channel, "Blisk", "/blisk/axis", "Axis", "X", "", Choice(AXES), "The blisk's axis in the coordinates of the mesh. It becomes the X axis of the workpiece frame W."),
    field(Stage::Channel, "Blisk", "/blisk/blades", "Blades", "", "", AutoInteger(Range(2.0, 1000.0), 60), "Number of blades around the axis."),
    field(Stage::Channel, "Blisk", "/blisk/channel", "Channel", "", "", Integer(Range(0.0, f64::INFINITY)), "Which channel: 0 is the one nearest to the mesh's +Z, the others follow in the sense of a right-handed turn about X."),
    field(Stage::Channel, "Radii", "/blisk/hub_radius_mm", "Hub radius", "R_h", "mm", AutoNumber(Range(1e-6, f64::INFINITY), 3, 100.0), "Radius of the hub along the whole channel; found from the mesh unless given."),
    field(Stage::Channel, "Radii", "/blisk/shroud_radius_mm", "Shroud radius", "R_c", "mm", AutoNumber(Range(1e-6, f64::INFINITY), 3, 125.0), "Radius of the shroud, or of the blade tips, along the whole channel; found from the mesh unless given."),
    field(Stage::Channel, "Wall grid", "/blisk/wall_points_chord", "Points along chord", "n_u", "", Integer(Range(5.0, 2000.0)), "Points of a channel wall from edge to edge."),
    field(Stage::Channel, "Wall grid", "/blisk/wall_points_span", "Points across", "n_v", "", Integer(Range(5.0, 2000.0)), "Points of a channel wall from hub to shroud."),

    field(Stage::Electrode, "Size", "/electrode/spark_gap_mm", "Spark gap", "g", "mm", Slider(Range(0.005, 2.0), Range(0.02, 0.4), 3), "Distance between the burning faces and the finished blisk in the final pose; the path keeps it all the way."),
    field(Stage::Electrode, "Size", "/electrode/circumferential_reduction_deg/0", "Reduction, low wall", "h", "deg", REDUCTION, "Angle by which this side of the electrode is turned about X away from its wall. A larger angle gives more clearance and leaves more stock for the copying motion."),
    field(Stage::Electrode, "Size", "/electrode/circumferential_reduction_deg/1", "Reduction, high wall", "h", "deg", REDUCTION, "Angle by which this side of the electrode is turned about X away from its wall."),
    field(Stage::Electrode, "Size", "/electrode/radial_reduction_mm", "Radial reduction", "", "mm", Slider(Range(0.0, 100.0), Range(0.0, 3.0), 3), "Distance by which the shroud side is moved inwards along the radius."),
    field(Stage::Electrode, "Entry", "/electrode/enter", "Enter from", "", "", Choice(SIDES), "Side of the blisk, in W, from which the electrode enters and to which it is retracted."),
    field(Stage::Electrode, "Entry", "/electrode/parts", "Parts", "", "", Integer(Range(1.0, 20.0)), "Number of electrodes along X (split along the passage)."),
    field(Stage::Electrode, "Entry", "/electrode/overlap_mm", "Overlap", "", "mm", Number(Range(0.0, 100.0), 2), "Overlap along X of the burns of two neighbouring parts, spark gaps included; with 0 they only meet."),
    field(Stage::Electrode, "Entry", "/electrode/columns", "Columns", "", "", Integer(Range(1.0, 2.0)), "2 splits every part left and right along the middle surface of the channel; each electrode burns one wall."),
    field(Stage::Electrode, "Entry", "/electrode/column_overlap_mm", "Column overlap", "", "mm", Number(Range(-20.0, 20.0), 2), "Overlap along the circumference of the burns of the two columns, spark gaps included; a negative value leaves a web."),
    field(Stage::Electrode, "Entry", "/electrode/column_split", "Column split", "", "", Slider(Range(0.1, 0.9), Range(0.1, 0.9), 2), "Share of the channel's width that belongs to the low column."),
    field(Stage::Electrode, "Body", "/electrode/overrun_mm", "Overrun", "", "mm", Number(Range(0.0, 100.0), 2), "How far the burning part reaches past the tips of the blades' edges, at most to the blisk's face."),
    field(Stage::Electrode, "Body", "/electrode/shank_inset_mm", "Shank inset", "", "mm", Number(Range(0.02, 20.0), 2), "How much smaller than the burning part the shank is all round."),
    field(Stage::Electrode, "Body", "/electrode/channel_shank_inset_mm", "Inset between blades", "", "mm", Number(Range(0.02, 20.0), 2), "The same for the shank of a part that stands deeper in the channel."),
    field(Stage::Electrode, "Body", "/electrode/shank_length_mm", "Shank length", "", "mm", Number(Range(0.5, 500.0), 1), "How far the shank reaches out of the blisk's face."),
    field(Stage::Electrode, "Body", "/electrode/holder_mm/0", "Holder along X", "", "mm", Number(Range(0.5, 500.0), 1), "Length of the holder block along X."),
    field(Stage::Electrode, "Body", "/electrode/holder_mm/1", "Holder across", "", "mm", Number(Range(0.5, 500.0), 1), "Width of the holder block; it grows where the shank is larger."),
    field(Stage::Electrode, "Body", "/electrode/holder_mm/2", "Holder along radius", "", "mm", Number(Range(0.5, 500.0), 1), "Height of the holder block; it grows where the shank is larger."),
    field(Stage::Electrode, "Own electrode", "/electrode/mesh", "Mesh", "", "", File, "An electrode of your own instead of a derived one, in its final pose in the coordinates of the blisk's mesh (mm)."),

    field(Stage::Plan, "Path", "/plan/strategy", "Strategy", "", "", Choice(STRATEGIES), "Search for the extraction path. Global: path of greatest clearance, with the reason where there is none. Genetic: the algorithm of the papers. Centreline: along the middle of the channel. The other two are for comparison."),
    field(Stage::Plan, "Path", "/plan/step_mm", "Step", "k", "mm", Number(Range(0.01, 10.0), 2), "Distance between nodes along X, or along the centreline if that is followed; halved where no free pose is found."),
    field(Stage::Plan, "Path", "/plan/exit_clearance_mm", "Exit clearance", "", "mm", Number(Range(0.1, 200.0), 1), "Distance by which the electrode is retracted out of the blisk."),
    field(Stage::Plan, "Path", "/plan/margin_mm", "Margin", "", "mm", Slider(Range(0.0, 5.0), Range(0.0, 0.5), 3), "Clearance wanted beyond the spark gap as soon as the electrode has left its final pose."),
    field(Stage::Plan, "Path", "/plan/constraint", "Constraint", "", "", Choice(CONSTRAINTS), "What a pose must meet during the search: the distance to the surface, or the paper's comparison of angles. The verifier has the last word either way."),
    field(Stage::Plan, "Global search", "/plan/global/poses", "Poses", "", "", Integer(Range(2.0, 1000.0)), "Poses kept for each node; three times as many are tried before it is given up."),
    field(Stage::Plan, "Global search", "/plan/global/room_mm", "Clearance margin", "", "mm", Number(Range(0.0, 5.0), 2), "Clearance beyond the required one up to which a wider path counts as better."),
    field(Stage::Plan, "Global search", "/plan/global/room_kept", "Margin kept", "", "", Slider(Range(0.0, 1.0), Range(0.0, 1.0), 2), "Share of the clearance margin that polishing keeps: 0 gives the smoothest path, 1 the widest."),
    field(Stage::Plan, "Centreline search", "/plan/centreline/safety_increase_mm", "Gap increase", "", "mm", Slider(Range(0.0, 5.0), Range(0.0, 0.5), 3), "Additional distance to the walls where the spark gap alone leads to no free motion."),
    field(Stage::Plan, "Genetic search", "/genetic/population", "Population", "", "", Integer(Range(4.0, 10000.0)), "Individuals in a generation."),
    field(Stage::Plan, "Genetic search", "/genetic/generations", "Generations", "", "", Integer(Range(1.0, 10000.0)), "Generations for each node."),
    field(Stage::Plan, "Genetic search", "/genetic/crossover", "Crossover", "k1, k3", "", Slider(Range(0.0, 1.0), Range(0.0, 1.0), 2), "Probability of crossover of parents worse than average; it falls to 0 for the best."),
    field(Stage::Plan, "Genetic search", "/genetic/mutation", "Mutation", "k2, k4", "", Slider(Range(0.0, 1.0), Range(0.0, 1.0), 2), "Probability that a gene of an individual worse than average mutates; it falls to 0 for the best."),
    field(Stage::Plan, "Genetic search", "/genetic/precision_mm", "Precision Y, Z", "", "mm", Number(Range(1e-5, 0.1), 5), "Step of Y and Z in the coding of an individual (8)."),
    field(Stage::Plan, "Genetic search", "/genetic/precision_deg", "Precision A, B, C, h", "", "deg", Number(Range(1e-5, 0.1), 5), "Step of angles in the coding of an individual (8)."),
    field(Stage::Plan, "Genetic search", "/genetic/h", "Reduction h", "h", "", Choice(H_MODES), "Given: the reduction above. Search: the least additional reduction with an extraction path."),
    field(Stage::Plan, "Genetic search", "/genetic/h_max_deg", "Greatest h", "", "deg", Number(Range(0.01, 20.0), 2), "The most that is searched for on top of the given reductions."),
    field(Stage::Plan, "Genetic search", "/genetic/seed", "Seed", "", "", Integer(Range(0.0, f64::INFINITY)), "The same seed gives the same path, to the last bit."),
    field(Stage::Plan, "Weights", "/plan/weights/a3", "Smoothness", "a3", "", WEIGHT, "Weight of smooth motion against centring; only the ratio of the two counts."),
    field(Stage::Plan, "Weights", "/plan/weights/b3", "Centring", "b3", "", WEIGHT, "Weight of staying in the middle of the channel."),
    field(Stage::Plan, "Weights", "/plan/weights/a1", "Smooth Z", "a1", "", WEIGHT, "Weight of Z among the axes."),
    field(Stage::Plan, "Weights", "/plan/weights/b1", "Smooth Y", "b1", "", WEIGHT, "Weight of Y among the axes."),
    field(Stage::Plan, "Weights", "/plan/weights/c1", "Smooth C", "c1", "", WEIGHT, "Weight of C among the axes."),
    field(Stage::Plan, "Weights", "/plan/weights/d1", "Smooth A", "", "", WEIGHT, "Weight of A among the axes, where the machine has it; the paper keeps A still."),
    field(Stage::Plan, "Weights", "/plan/weights/e1", "Smooth B", "", "", WEIGHT, "Weight of B among the axes, where the machine has it."),
    field(Stage::Plan, "Weights", "/plan/weights/a2", "Equal distances", "a2", "", WEIGHT, "Weight of equal least distances to both walls."),
    field(Stage::Plan, "Weights", "/plan/weights/b2", "Even along low wall", "b2", "", WEIGHT, "Weight of even distances along the low wall (the paper's left)."),
    field(Stage::Plan, "Weights", "/plan/weights/c2", "Even along high wall", "c2", "", WEIGHT, "Weight of even distances along the high wall (the paper's right)."),
    field(Stage::Plan, "Machine", "/machine/axes", "Axes", "", "", Choice(MACHINES), "Axes that the machine moves together."),
    field(Stage::Plan, "Machine", "/machine/name", "Bodies", "", "", ChoiceOrFile(BODIES), "The machine whose axes, travels and bodies count: the whole motion is simulated with its head, holder and table. A machine is a TOML file; one of your own can be chosen."),
    field(Stage::Plan, "Machine", "/machine/body_clearance_mm", "Body clearance", "", "mm", Number(Range(0.01, 100.0), 2), "How far bodies of the machine stay from each other and from the blisk."),
    field(Stage::Plan, "Machine", "/export/channels", "Channels", "", "", Choice(CHANNELS), "In which channels the motion is simulated and which the NC program burns, A turning the blisk to them."),
    field(Stage::Plan, "Fine points", "/plan/field_cell_mm", "Field cell", "", "mm", Number(Range(0.05, 2.0), 2), "Size of a cell of the distance field that the search works on."),
    field(Stage::Plan, "Fine points", "/plan/interpolation/kind", "Curve", "", "", Choice(CURVES), "What joins the nodes of each axis: cubic splines whose knots are the nodes, or NURBS with averaged knots."),
    field(Stage::Plan, "Fine points", "/plan/interpolation/degree", "Degree of NURBS", "p", "", Integer(Range(3.0, 5.0)), "The degree of the NURBS through the nodes; splines are cubic."),
    field(Stage::Plan, "Fine points", "/plan/interpolation/chord_error_mm", "Chord error", "", "mm", Number(Range(5e-5, 0.1), 5), "How far linear motion between rows may be from the curves through the nodes, anywhere on the electrode."),

    field(Stage::Verify, "Certificate", "/verify/tolerance_mm", "Tolerance", "", "mm", Number(Range(0.0, 0.05), 4), "Accepted shortfall of the clearance below the spark gap."),
    field(Stage::Verify, "Certificate", "/verify/resolution_mm", "Resolution", "", "mm", Number(Range(1e-6, 1.0), 6), "How close the proven bound comes to the smallest clearance met."),
    field(Stage::Verify, "Certificate", "/verify/stop_at_violation", "Stop at violation", "", "", Flag, "Stops at the first violation without searching for others."),

    field(Stage::Export, "NC program", "/export/post", "Post-processor", "", "", ChoiceOrFile(POSTS), "The words that the control understands. A post is a TOML file; one of your own can be chosen."),
    field(Stage::Export, "NC program", "/export/nc/feed_mm_per_min", "Feed", "", "mm/min", Number(Range(0.001, 100000.0), 1), "Feed towards the final pose. While eroding, the generator's servo sets the pace; this is its limit."),
    field(Stage::Export, "NC program", "/export/nc/retract_mm_per_min", "Retraction", "", "mm/min", Number(Range(0.001, 100000.0), 1), "Feed of the approach and of the retraction."),
    field(Stage::Export, "NC program", "/export/nc/burn_dwell_s", "Dwell", "", "s", Number(Range(0.0, 1e6), 1), "Dwell in the final pose after the stop for the burn; 0 for none."),
    field(Stage::Export, "Files", "/export/frame", "Electrode in", "", "", Choice(FRAMES), "The frame of electrode_K.stl: that of the loaded mesh, or the workpiece frame W, whose place in the loaded mesh stands in every result."),
    field(Stage::Export, "Files", "/export/files/electrode", "Electrode", "", "", Flag, "electrode_K.stl: each electrode in its final pose."),
    field(Stage::Export, "Files", "/export/files/path", "Path", "", "", Flag, "path_K.csv: the rows of the motion, in W."),
    field(Stage::Export, "Files", "/export/files/nc", "NC program", "", "", Flag, "path_K.nc through the post. Only a certified path has one."),
    field(Stage::Export, "Files", "/export/files/report", "Report", "", "", Flag, "report.html for people and report.json for programs."),
    field(Stage::Export, "Files", "/export/files/leftover", "Residual stock", "", "", Flag, "leftover.ply: the surface of the channel with the residual stock at every vertex. copying_K.csv: the copying motion of each certified path."),
    field(Stage::Export, "Files", "/export/files/pictures", "Pictures", "", "", Flag, "The pictures as PNG files. The page of the report holds them in any case."),
    field(Stage::Export, "Pictures", "/export/pictures/whole", "Whole blisk", "", "", Flag, "The whole blisk with its electrodes before it."),
    field(Stage::Export, "Pictures", "/export/pictures/final_pose", "Final pose", "", "", Flag, "Each electrode in its final pose in the channel."),
    field(Stage::Export, "Pictures", "/export/pictures/sweep", "Sweep", "", "", Flag, "Each electrode in many poses along its path."),
    field(Stage::Export, "Pictures", "/export/pictures/closest", "Closest point", "", "", Flag, "A section where each electrode comes closest, or jams."),
    field(Stage::Export, "Pictures", "/export/pictures/leftover", "Residual stock", "", "", Flag, "The residual stock on the surfaces of the channel, as colours."),
];
