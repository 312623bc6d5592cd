//! Report of an import for the user: findings, repairs and remaining defects.

use glam::DVec3;
use serde::Serialize;

use super::format::Format;
use super::holes::Hole;
use super::repair::Repairs;
use super::solids::SolidReport;
use super::source::count;
use super::units::{Unit, UnitChoice};
use geometry::mesh::Mesh;

/// Report of the import of a mesh: findings, repairs and remaining defects. Lengths are in mm after conversion.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct ImportReport {
    /// Format, told by the content.
    pub format: Format,
    /// Unit of the coordinates in the file.
    pub unit: Unit,
    /// Reason why this unit is taken.
    pub unit_reason: String,
    /// Whether the unit is beyond doubt; if not, ask the user.
    pub unit_certain: bool,
    /// Triangles in the file.
    pub triangles_read: usize,
    /// Triangles of the mesh.
    pub triangles: usize,
    /// Vertices of the mesh, after welding.
    pub vertices: usize,
    /// Distance within which vertices were taken for one (mm). It is only applied to a mesh that does not close
    /// otherwise.
    pub weld_tolerance_mm: f64,
    /// Whether the tolerance was applied.
    pub welded_within_tolerance: bool,
    /// Triangles removed because two of their corners are the same point.
    pub degenerate_removed: usize,
    /// Triangles removed because they lay on others.
    pub duplicates_removed: usize,
    /// Edges along which solids touch, or one touches itself: they were split, so that the surface closes.
    pub touching_edges: usize,
    /// Triangles without height that were given one by exchanging an edge with a neighbour.
    pub slivers_exchanged: usize,
    /// Triangles without height that remain.
    pub slivers_kept: usize,
    /// Triangles turned because they disagreed with most of their part.
    pub triangles_flipped: usize,
    /// Whether the whole mesh was turned inside out.
    pub turned_inside_out: bool,
    /// Parts: triangles connected over edges that join exactly two of them.
    pub components: usize,
    /// Parts turned inside out as a whole.
    pub components_turned: usize,
    /// Parts that bound a cavity within another.
    pub cavities: usize,
    /// Number of boundary loops.
    pub hole_count: usize,
    /// The longest boundary loops.
    pub holes: Vec<Hole>,
    /// Number of edges of three or more triangles.
    pub non_manifold_edges: usize,
    /// Middle points of the first of them (mm).
    pub non_manifold_places_mm: Vec<DVec3>,
    /// Whether every edge joins exactly two triangles of agreeing orientation.
    pub watertight: bool,
    /// Least coordinates (mm).
    pub min_mm: DVec3,
    /// Extent along the file's axes (mm).
    pub size_mm: DVec3,
    /// Enclosed volume (mm^3); without meaning unless watertight.
    pub volume_mm3: f64,
    /// Solids of a file that has such.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub solids: Vec<SolidReport>,
    /// Greatest distance of the triangles from the exact faces of a STEP file (mm).
    #[serde(skip_serializing_if = "Option::is_none")]
    pub step_tolerance_mm: Option<f64>,
    /// Everything the user should know, in plain sentences.
    pub warnings: Vec<String>,
}

/// How many boundary loops a report lists.
const HOLES_LISTED: usize = 100;

impl ImportReport {
    /// Puts the report together; `warnings` are those of the reader.
    pub(super) fn new(
        format: Format,
        triangles_read: usize,
        mesh: &Mesh,
        unit: UnitChoice,
        repairs: Repairs,
        warnings: Vec<String>,
    ) -> Self {
        let bounds = mesh.bounds();
        let orientation = &repairs.orientation;
        let mut holes = repairs.holes;
        let hole_count = holes.len();
        holes.sort_by(|a, b| b.length_mm.total_cmp(&a.length_mm));
        holes.truncate(HOLES_LISTED);
        let mut report = Self {
            format,
            unit: unit.unit,
            unit_reason: unit.reason,
            unit_certain: unit.certain,
            triangles_read,
            triangles: mesh.triangles.len(),
            vertices: mesh.vertices.len(),
            weld_tolerance_mm: repairs.weld_tolerance,
            welded_within_tolerance: repairs.welded_near,
            degenerate_removed: repairs.collapsed,
            duplicates_removed: repairs.duplicates,
            touching_edges: repairs.touching_edges,
            slivers_exchanged: repairs.slivers.exchanged,
            slivers_kept: repairs.slivers.kept,
            triangles_flipped: orientation.flipped,
            turned_inside_out: orientation.parts > 0 && orientation.turned == orientation.parts,
            components: orientation.parts,
            components_turned: orientation.turned,
            cavities: orientation.cavities,
            hole_count,
            holes,
            non_manifold_edges: repairs.non_manifold_edges,
            non_manifold_places_mm: repairs.non_manifold_places,
            watertight: repairs.watertight,
            min_mm: bounds.min,
            size_mm: bounds.size(),
            volume_mm3: mesh.volume(),
            solids: Vec::new(),
            step_tolerance_mm: None,
            warnings,
        };
        report.warn(orientation.one_sided, orientation.unsure, orientation.nesting_unknown);
        report
    }

    /// Reason why the unit may be another, in a sentence; none if it is beyond doubt.
    pub fn unit_doubt(&self) -> Option<String> {
        (!self.unit_certain).then(|| format!("The unit is a guess: {}. Set it if this is wrong.", self.unit_reason))
    }

    /// How near the triangles are to the exact faces of the file, in a sentence; none of a file of triangles.
    pub fn accuracy(&self) -> Option<String> {
        let tolerance = self.step_tolerance_mm?;
        Some(format!(
            "Every figure is of triangles that lie within {tolerance} mm of the exact faces of the STEP file \
             (step_tolerance_mm)."
        ))
    }

    /// Sentences that belong beside every result: doubt about the unit, and accuracy.
    pub fn notes(&self) -> impl Iterator<Item = String> {
        self.unit_doubt().into_iter().chain(self.accuracy())
    }

    /// Says in sentences what the figures mean.
    fn warn(&mut self, one_sided: usize, unsure: usize, nesting_unknown: bool) {
        self.warnings.extend(self.unit_doubt());
        let mut warn = |is_so: bool, sentence: String| {
            if is_so {
                self.warnings.push(sentence);
            }
        };
        if let Some(longest) = self.holes.first() {
            let [x, y, z] = longest.center_mm.to_array();
            let length = longest.length_mm;
            let holes = count(self.hole_count, "hole");
            warn(
                true,
                format!("The surface has {holes}; the longest is {length:.3} mm round ({x:.3}, {y:.3}, {z:.3})."),
            );
        }
        if let Some(place) = self.non_manifold_places_mm.first() {
            let [x, y, z] = place.to_array();
            let edges = count(self.non_manifold_edges, "edge");
            warn(true, format!("{edges} of three or more triangles, the first at ({x:.3}, {y:.3}, {z:.3})."));
        }
        let touching = count(self.touching_edges, "edge");
        warn(
            self.touching_edges > 0,
            format!("Solids touch along {touching}; the surface was split there, so that each solid is closed."),
        );
        let doubts = [
            (self.duplicates_removed, "doubled triangle", "removed"),
            (self.degenerate_removed, "collapsed triangle", "removed"),
            (self.slivers_kept, "triangle", "without height left in place, as removal would open the surface"),
            (self.triangles_flipped, "triangle", "turned to agree with the rest"),
            (one_sided, "part", "of one side only: inside and outside cannot be told apart"),
            (unsure, "open or flat part", "left in the direction of the file, as the outside cannot be told"),
        ];
        for (n, what, done) in doubts {
            warn(n > 0, format!("{} {done}.", count(n, what)));
        }
        warn(self.turned_inside_out, "The mesh was inside out and has been turned.".to_owned());
        let some_turned = self.components_turned > 0 && !self.turned_inside_out;
        warn(some_turned, format!("{} turned inside out.", count(self.components_turned, "part")));
        let assumption = "There are too many parts to see which lie inside others; all are taken for solid.";
        warn(nesting_unknown, assumption.to_owned());
    }
}
