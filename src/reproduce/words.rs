//! Words of the reproduction page that a reader of the papers cannot know, each said once.

type Words = &'static [(&'static str, &'static str)];

/// Of feed paths.
pub(super) const OF_BLISKS: Words = &[
    ("channel", "the passage between two neighbouring blades, closed by hub and shroud; the blisk's axis is X"),
    (
        "low wall, high wall",
        "the walls of the channel on the side of the smaller and of the greater angle about X; the papers' left and right wall",
    ),
    ("net-shape electrode", "the channel less the spark gap all round, without any reduction"),
    (
        "reduction",
        "the walls of the electrode turned away from the blades (P0's h), and its shroud side drawn in, so that it can move",
    ),
    (
        "s, retracted",
        "distance by which the electrode is withdrawn from its final pose, along X here; the feed runs towards s = 0",
    ),
    ("node", "a place on the way out for which the search finds a pose; curves through the nodes are the path"),
    ("centroid", "the middle of the electrode's burning faces"),
    ("certified", "proven as a lower bound of the distance over the whole continuous motion, not at nodes alone"),
];

/// Of the centreline of a channel.
pub(super) const OF_CENTRELINES: Words = &[
    ("low wall, high wall", "the walls of a channel on the side of the smaller and of the greater angle about X"),
    (
        "part 1, part 2",
        "the front and the rear electrode: the channel divided across its length, part 1 at the smaller X",
    ),
    (
        "low, high",
        "the two columns of a part: the channel divided along its middle surface; each burns the \
         wall that it is named after",
    ),
    ("core point v", "the middle of the electrode's section square to the centreline, which follows that line"),
    (
        "d1 to d4",
        "distances of the electrode to pressure wall, suction wall, hub and shroud: the paper's delta_1 to delta_4",
    ),
    (
        "deviation",
        "distance of a measured point from the wall along its normal: positive into the channel, where the blade is too thick, \
         negative where it is too thin",
    ),
    ("certified", "proven as a lower bound of the distance over the whole continuous motion, not at nodes alone"),
];

/// Of molds and their electrodes.
pub(super) const OF_MOLDS: Words = &[
    ("uncut", "what no cutter of the list reaches: it is left for electrodes"),
    ("region", "a connected piece of uncut surface"),
    (
        "inner edge, H-edge",
        "a concave edge of an electrode that no cutter for electrodes can mill; such an electrode is divided there",
    ),
    ("head", "the burning part of an electrode for one region, the paper's tip; several heads may stand on one base"),
    ("base", "the block that carries the heads and is clamped in the holder"),
    ("burn", "one descent of one electrode at one place; an electrode with several burns is used at several places"),
    ("oversize", "what an electrode covers beyond the region that it is for"),
    ("layer, section", "a plane square to the opening direction, on which the cutters are tested"),
];

/// Of flank milling.
pub(super) const OF_FLANKS: Words = &[
    (
        "lower guide, upper guide",
        "the two curves that the ruled surface joins by straight lines: lower the one at the cutter's tip. u runs along them \
         from their beginning, v from the lower to the upper guide",
    ),
    ("flutes", "the cutting length of the cutter from its tip up"),
    (
        "flutes end above the lower guide",
        "how far the cutter's tip stays above the lower guide at the worst place of a path, so that a strip there is not cut",
    ),
    (
        "deviation",
        "distance of the milled from the wanted surface along its normal: positive (undercut, red) where stock is left, negative \
         (overcut, blue) where too much is gone",
    ),
    (
        "ratio to initial",
        "sum of the absolute deviations of a path over that of the three-point path that it begins from",
    ),
    ("rank", "number of singular values that the solution of the linear system keeps: the paper's k"),
    ("(t, a) and (u, v)", "grids of samples: even in the axis surface's parameters, or even in the surface's"),
];
