//! The parameters of a mold.

pub mod cutter_file;
pub mod demonstration;
pub mod fields;
pub mod holder_files;
pub mod standard;

use std::path::{Path, PathBuf};

use geometry::mesh::Mesh;
use serde::{Deserialize, Serialize};

use crate::workspaces::mold::document::cutter_file::standard_cutters;
use crate::workspaces::mold::job::uncut::UncutParams;
use crate::workspaces::setup::SetUpSheet;
use files::{Invalid, Params, Validate};
use import::{Imported, Reading, SolidReport, Units};
use mold::cutter::CutterLibrary;
use mold::datum::Datum;
use mold::electrode::params::ElectrodeParams;
use mold::layers::LayerSettings;
use mold::opening::Opening;
use mold::unseen::OpeningProposal;
use task::{Cancel, Cancelled};

/// Parameters of a mold.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct MoldParams {
    /// Mesh of the mold; none as long as nothing is loaded, where the window shows the demonstration mold.
    pub mesh: Option<PathBuf>,
    /// Unit of the mesh.
    pub units: Units,
    /// Numbers of the solids of a STEP file, from 1, that make the mold. If there are none, the largest that is no
    /// obstacle and all others that lie beside it.
    pub solids: Vec<u32>,
    /// Numbers of the solids of a STEP file that are obstacles: a fixture, or a part beside the mold.
    pub obstacles: Vec<u32>,
    /// Greatest distance of the triangles from the exact faces of a STEP file (mm).
    pub step_tolerance_mm: f64,
    /// The part that decisions were made for: the digest of its file and the unit, as read last. None before that.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub part: Option<String>,
    /// Opening direction, in the axes of the mesh; none, `"auto"`, until the one that is proposed for the part is taken.
    #[serde(with = "or_auto")]
    pub opening: Option<Opening>,
    /// Thickness of the residue, across the mold's surface, up to which it counts as cut (mm).
    pub tolerance_mm: f64,
    /// Step of the height map (mm); none to choose it automatically.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub grid_step_mm: Option<f64>,
    /// Work datum, to which positions of burns refer.
    pub datum: Datum,
    /// Settings of the set-up sheet.
    pub setup: SetUpSheet,
    /// Settings of the layers.
    pub layers: LayerSettings,
    /// The cutters.
    pub library: CutterLibrary,
    /// Parameters of electrodes. If there are no holders, those of the user's library are used.
    pub electrodes: ElectrodeParams,
}

impl Default for MoldParams {
    fn default() -> Self {
        Self {
            mesh: None,
            units: Units::Auto,
            solids: Vec::new(),
            obstacles: Vec::new(),
            step_tolerance_mm: Reading::STEP_TOLERANCE,
            part: None,
            opening: None,
            datum: Datum::default(),
            setup: SetUpSheet::default(),
            tolerance_mm: 0.02,
            grid_step_mm: None,
            layers: LayerSettings::default(),
            // A program that was built with a file that is none has no cutters to begin with.
            library: standard_cutters().unwrap_or_default(),
            electrodes: ElectrodeParams::default(),
        }
    }
}

impl MoldParams {
    /// Solids, tolerance and unit in which the mesh file is read.
    pub fn reading(&self) -> Reading {
        Reading {
            units: self.units,
            solids: self.solids.clone(),
            obstacles: self.obstacles.clone(),
            step_tolerance_mm: self.step_tolerance_mm,
        }
    }
}

impl Validate for MoldParams {
    fn validate(&self) -> Result<(), Invalid> {
        fields::FIELDS.check(self)?;
        self.datum.validate().map_err(|problem| problem.within("datum"))?;
        self.setup.validate().map_err(|problem| problem.within("setup"))?;
        Validate::validate(&self.library).map_err(|problem| problem.within("library"))?;
        self.layers.validate().map_err(|problem| problem.within("layers"))?;
        if let Some(step) = self.grid_step_mm {
            let radii = self.library.needed().into_iter().map(|cutter| cutter.radius());
            let most = 0.5 * radii.fold(f64::INFINITY, f64::min);
            Invalid::unless_within("grid_step_mm", step, [1e-6, most], "mm, half the radius of the smallest cutter")?;
        }
        Validate::validate(&self.electrodes).map_err(|problem| problem.within("electrodes"))
    }
}

impl Params for MoldParams {
    const KIND: &'static str = "mold";

    fn part(&self) -> String {
        self.mesh.as_deref().and_then(Path::file_stem).map_or_else(String::new, |n| n.to_string_lossy().into_owned())
    }

    fn name(&self) -> String {
        if self.mesh.is_some() { self.part() } else { demonstration::DEMONSTRATION.to_owned() }
    }

    fn change_paths(&mut self, change: &mut dyn FnMut(&Path) -> PathBuf) {
        if let Some(mesh) = &mut self.mesh {
            *mesh = change(mesh);
        }
        let technology = &mut self.electrodes.technology;
        if technology.is_file() {
            technology.table = change(Path::new(&technology.table)).to_string_lossy().into_owned();
        }
    }
}

impl MoldParams {
    /// Opening direction; +Z as long as none is known.
    pub fn opening(&self) -> Opening {
        self.opening.unwrap_or_default()
    }

    /// Takes the opening direction that is proposed for the part's mesh, if none is given. Returns the proposal then.
    ///
    /// # Errors
    /// If it is cancelled.
    pub fn open(&mut self, mesh: &Mesh, cancel: &Cancel) -> Result<Option<OpeningProposal>, Cancelled> {
        if self.opening.is_some() {
            return Ok(None);
        }
        let proposal = OpeningProposal::of(mesh, cancel)?;
        self.opening = Some(proposal.opening);
        Ok(Some(proposal))
    }

    /// Parameters of the search for uncut regions.
    pub fn uncut(&self) -> UncutParams {
        UncutParams {
            library: self.library.clone(),
            opening: self.opening(),
            tolerance_mm: self.tolerance_mm,
            grid_step_mm: self.grid_step_mm,
            layers: self.layers.clone(),
        }
    }

    /// The parameters without decisions for one part: opening direction, work datum, datums of the set-up sheet, division
    /// and burn directions of regions, overrides, and names of electrodes.
    pub fn undecided(&self) -> Self {
        let (edits, overrides, names) = (Vec::new(), Vec::new(), Vec::new());
        let electrodes = ElectrodeParams { edits, overrides, names, ..self.electrodes.clone() };
        Self { opening: None, datum: Datum::default(), setup: self.setup.of_any_part(), electrodes, ..self.clone() }
    }

    /// Decisions of `before` that these parameters no longer have, because the part is another one, in words; none
    /// if there were none.
    pub fn dropped(&self, before: &Self) -> Option<String> {
        let mut dropped = Vec::new();
        if let Some(opening) = before.opening.filter(|_| self.opening != before.opening) {
            let now = self.opening.map_or_else(String::new, |now| format!(" (now {})", now.name()));
            dropped.push(format!("opening direction {}{now}", opening.name()));
        }
        if self.datum != before.datum {
            dropped.push(format!("work datum {}", before.datum.label()));
        }
        let (own, former) = (&self.electrodes, &before.electrodes);
        let datums = &self.setup.datum;
        let lists = [
            (before.setup.datum.iter().filter(|row| !datums.contains(row)).count(), "datum of the set-up sheet"),
            (former.edits.iter().filter(|edit| !own.edits.contains(edit)).count(), "change of divisions and burns"),
            (former.overrides.iter().filter(|one| !own.overrides.contains(one)).count(), "override"),
            (former.names.iter().filter(|name| !own.names.contains(name)).count(), "name of electrodes"),
        ];
        for (count, what) in lists.into_iter().filter(|(count, _)| *count > 0) {
            let (one, rest) = what.split_once(' ').map_or((what, String::new()), |(one, of)| (one, format!(" {of}")));
            dropped.push(format!("{count} {one}{}{rest}", if count == 1 { "" } else { "s" }));
        }
        (!dropped.is_empty()).then(|| {
            format!(
                "the mesh or its unit has changed: what was chosen for the former one is dropped: {}; choose it again",
                dropped.join(", ")
            )
        })
    }

    /// A copy of the parameters without the decisions that were made for another part than `part`.
    pub fn of_part(&self, part: &str) -> Self {
        let is_other = self.part.as_ref().is_some_and(|own| own != part);
        let params = if is_other { self.undecided() } else { self.clone() };
        Self { part: Some(part.to_owned()), ..params }
    }
}

/// An opening direction in files, or `"auto"` for none.
mod or_auto {
    use super::{Deserialize, Opening, Serialize};
    use serde::{Deserializer, Serializer};

    #[derive(Serialize, Deserialize)]
    enum Word {
        #[serde(rename = "auto")]
        Auto,
    }

    #[derive(Serialize, Deserialize)]
    #[serde(untagged, expecting = "expected auto, +x, -x, +y, -y, +z, -z, or three numbers as in [0, 0.5, 1]")]
    enum Written {
        Auto(Word),
        Given(Opening),
    }

    pub(super) fn serialize<S: Serializer>(opening: &Option<Opening>, serializer: S) -> Result<S::Ok, S::Error> {
        opening.map_or(Written::Auto(Word::Auto), Written::Given).serialize(serializer)
    }

    pub(super) fn deserialize<'de, D: Deserializer<'de>>(deserializer: D) -> Result<Option<Opening>, D::Error> {
        Ok(match Written::deserialize(deserializer)? {
            Written::Auto(Word::Auto) => None,
            Written::Given(opening) => Some(opening),
        })
    }
}

/// Digest of a part: digest of its file, the unit that it was read in, and of a STEP file what was taken of it.
pub fn part_of(imported: &Imported) -> String {
    let report = &imported.report;
    let mut part = format!("{} {}", imported.sha256, report.unit.name());
    if let Some(tolerance) = report.step_tolerance_mm {
        let numbers = |is_meant: fn(&&SolidReport) -> bool| {
            report.solids.iter().filter(is_meant).map(|s| s.number.to_string()).collect::<Vec<_>>().join(" ")
        };
        part.push_str(&format!(" {tolerance} mm, united solids {}", numbers(|s| s.is_taken)));
        if imported.obstacles.is_some() {
            part.push_str(&format!(", obstacles {}", numbers(|s| s.is_obstacle)));
        }
    }
    part
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::workspaces::setup::DatumRow;
    use files::Document;
    use mold::cutter::Cutter;
    use mold::electrode::params::Edit;

    #[test]
    fn a_mold_is_read_as_it_was_written_and_finds_its_mesh_beside_it() {
        let folder = tempfile::tempdir().unwrap();
        let [here, there] = ["here", "there"].map(|name| folder.path().join(name));
        [&here, &there].into_iter().for_each(|f| std::fs::create_dir(f).unwrap());
        let mut params = MoldParams { mesh: Some(here.join("part.stl")), ..MoldParams::default() };
        (params.opening, params.tolerance_mm) = (Opening::along(glam::DVec3::ONE), 0.05);
        params.datum = Datum::default().at(glam::DVec3::new(1.0, -2.5, 0.125), "corner");
        params.setup.datum = vec![DatumRow { x_mm: 0.1, y_mm: -2.0, z_mm: 1e-7, radius_mm: Some(10.0) }];
        (params.setup.round_mm, params.setup.a_axis_mm) = (Some(0.01), Some([0.0, -50.0]));
        params.electrodes.edits.push(Edit::Split { line: [glam::DVec3::X, glam::DVec3::Y] });
        params.electrodes.overrides.push("E01:gouge".parse().unwrap());
        params.library.cutter.push(Cutter { reach_mm: Some(12.0), ..Cutter::bull_nose(3.0, 0.5) });
        let file = here.join("part.sparkpath");
        Document::new(params.clone()).export(&file).unwrap();
        let read = |file: &Path| Document::<MoldParams>::open(file).unwrap().params().clone();
        assert_eq!(read(&file), params);
        let short = here.join("short.sparkpath");
        std::fs::write(&short, "kind = \"mold\"\n[electrodes]\noverrides = [\"E03:gouge\"]").unwrap();
        let MoldParams { electrodes, .. } = read(&short);
        assert!(electrodes.overrides[0].of == "E03" && electrodes.overrides[0].check == "gouge");
        let plain = ElectrodeParams { overrides: Vec::new(), ..electrodes };
        assert_eq!(MoldParams { electrodes: plain, ..read(&short) }, MoldParams::default());
        std::fs::copy(&file, there.join("copy.sparkpath")).unwrap();
        assert_eq!(read(&there.join("copy.sparkpath")).mesh, Some(there.join("part.stl")));
    }

    #[test]
    fn what_is_no_mold_is_answered_with_the_place_and_the_reason() {
        let folder = tempfile::tempdir().unwrap();
        let file = folder.path().join("wrong.sparkpath");
        for (text, words) in [
            ("tolerance_mm = -1", "line 2: tolerance_mm is -1"),
            ("tolerance_mm = nan", "tolerance_mm is nan"),
            ("opening = \"up\"", "line 2: opening: expected auto, +x"),
            ("[datum]\nangle_deg = 400", "line 3: datum.angle_deg is 400"),
            ("[setup]\npresets = \"own.csv\"", "line 3: setup.presets: unknown field"),
            ("[[setup.datum]]\nx_mm = 1\ny_mm = 2\nz_mm = 3\nradius_mm = 0", "line 6: setup.datum[0].radius_mm is 0"),
            ("[setup]\na_axis_mm = [0, 5]", "line 3: setup.a_axis_mm: a table is checked with a ball"),
            ("[[library.cutter]]\ndiameter_mm = 0", "line 3: library.cutter[0].diameter_mm is 0"),
            ("library = {}", "no cutter"),
            ("tolerance = 1", "unknown field"),
            ("[electrodes]\nmargin_mm = -1", "line 3: electrodes.margin_mm is -1"),
        ] {
            std::fs::write(&file, format!("kind = \"mold\"\n{text}")).unwrap();
            let said = Document::<MoldParams>::open(&file).unwrap_err().to_string();
            assert!(said.contains("wrong.sparkpath") && said.contains(words), "{text}: {said}");
        }
        // What the machine touches on one part is not there on another one.
        let row = DatumRow { x_mm: 1.0, y_mm: 2.0, z_mm: 3.0, radius_mm: Some(4.0) };
        let setup =
            SetUpSheet { datum: vec![row], round_mm: Some(0.01), a_axis_mm: Some([0.0, 5.0]), ..SetUpSheet::default() };
        let before = MoldParams { part: Some("one".to_owned()), setup, ..MoldParams::default() };
        let now = before.of_part("other");
        assert_eq!(now.setup, SetUpSheet { round_mm: Some(0.01), ..SetUpSheet::default() });
        assert!(now.validate().is_ok() && before.of_part("one") == before);
        assert!(now.dropped(&before).unwrap().contains("dropped: 1 datum of the set-up sheet; choose"));
        let broken = MoldParams { tolerance_mm: 0.0, ..MoldParams::default() };
        assert!(Document::new(broken).export(&file).is_err());
    }
}
