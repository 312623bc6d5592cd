//! What a user chooses for a mold.

pub mod cutter_file;
pub mod holder_files;
pub mod standard;

use std::path::{Path, PathBuf};

use serde::{Deserialize, Serialize};

use crate::workspaces::mold::document::cutter_file::standard_cutters;
use crate::workspaces::mold::job::uncut::UncutParams;
use files::{Invalid, Params, Validate};
use import::{Imported, Units};
use mold::cutter::CutterLibrary;
use mold::electrode::params::{Edit, ElectrodeParams};
use mold::layers::LayerSettings;
use mold::opening::Opening;

/// A mold and the question about it.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct MoldParams {
    /// Its mesh; none as long as nothing is loaded.
    pub mesh: Option<PathBuf>,
    /// Unit of the mesh.
    pub units: Units,
    /// The part that everything was decided for: the digest of its file and the unit it was read in, as they were when
    /// it was read last. None before that.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub part: Option<String>,
    /// The direction in which its opening looks, in the axes of the mesh.
    pub opening: Opening,
    /// Thickness of the residue, across the mold's surface, up to which it counts as cut (mm).
    pub tolerance_mm: f64,
    /// Step of the height map (mm); none for as fine as it has to be and can be.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub grid_step_mm: Option<f64>,
    /// How finely the mold is cut into layers.
    pub layers: LayerSettings,
    /// The cutters.
    pub library: CutterLibrary,
    /// What is asked of electrodes for what they leave. Without holders these are those of the user's library.
    pub electrodes: ElectrodeParams,
}

impl Default for MoldParams {
    fn default() -> Self {
        Self {
            mesh: None,
            units: Units::Auto,
            part: None,
            opening: Opening::default(),
            tolerance_mm: 0.02,
            grid_step_mm: None,
            layers: LayerSettings::default(),
            // A program that was built with a file that is none has no cutters to begin with.
            library: standard_cutters().unwrap_or_default(),
            electrodes: ElectrodeParams::default(),
        }
    }
}

impl Validate for MoldParams {
    fn validate(&self) -> Result<(), Invalid> {
        Validate::validate(&self.library).map_err(|problem| problem.within("library"))?;
        Invalid::unless_within("tolerance_mm", self.tolerance_mm, [1e-4, 10.0], "mm")?;
        self.layers.validate().map_err(|e| {
            Invalid::new(format!("layers.{}", e.name), e.value, format!("must be from {} to {}", e.from, e.to))
        })?;
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
        if self.mesh.is_some() { self.part() } else { "No mold".to_owned() }
    }

    fn change_paths(&mut self, change: &mut dyn FnMut(&Path) -> PathBuf) {
        if let Some(mesh) = &mut self.mesh {
            *mesh = change(mesh);
        }
    }
}

impl MoldParams {
    /// What is asked of the cutters.
    pub fn uncut(&self) -> UncutParams {
        UncutParams {
            library: self.library.clone(),
            opening: self.opening,
            tolerance_mm: self.tolerance_mm,
            grid_step_mm: self.grid_step_mm,
            layers: self.layers.clone(),
        }
    }

    /// Parameters without what was decided for one part only: where it opens to, how its regions are divided and burned,
    /// which of its electrodes are exported although a check fails, and what they are called.
    pub fn undecided(&self) -> Self {
        let (edits, overrides, names) = (Vec::new(), Vec::new(), Vec::new());
        let electrodes = ElectrodeParams { edits, overrides, names, ..self.electrodes.clone() };
        Self { opening: Opening::default(), electrodes, ..self.clone() }
    }

    /// What of these parameters holds for `part`: what was decided for another one does not.
    pub fn of_part(&self, part: &str) -> Self {
        let is_other = self.part.as_ref().is_some_and(|own| own != part);
        let params = if is_other { self.undecided() } else { self.clone() };
        Self { part: Some(part.to_owned()), ..params }
    }

    /// What makes these parameters others than those of `before`, as a step that can be undone is called.
    pub fn change_since(&self, before: &Self) -> String {
        if self.library != before.library {
            return change_of_cutters(&self.library, &before.library);
        }
        if self.electrodes != before.electrodes {
            return change_of_electrodes(&self.electrodes, &before.electrodes);
        }
        let what = [
            (self.mesh != before.mesh, "Mesh"),
            (self.units != before.units, "Unit"),
            (self.opening != before.opening, "Opening direction"),
            (self.tolerance_mm != before.tolerance_mm, "Tolerance"),
            (self.grid_step_mm != before.grid_step_mm, "Step of the height map"),
            (self.layers != before.layers, "Layers"),
        ];
        what.iter().find(|(differs, _)| *differs).map_or("", |(_, name)| name).to_owned()
    }
}

/// What tells a part from any other: the digest of its file, and the unit that it was read in.
pub fn part_of(imported: &Imported) -> String {
    format!("{} {}", imported.sha256, imported.report.unit.name())
}

/// The same of cutters.
fn change_of_cutters(now: &CutterLibrary, before: &CutterLibrary) -> String {
    let (now, before) = (&now.cutter, &before.cutter);
    if now.len() == before.len() + 1 {
        return "New cutter".to_owned();
    }
    if now.len() + 1 == before.len() {
        return "Removal of a cutter".to_owned();
    }
    let mut differing = now.iter().zip(before).enumerate().filter(|(_, (now, before))| now != before);
    let (Some((i, (now, before))), None) = (differing.next(), differing.next()) else { return "Cutters".to_owned() };
    let what = [
        (now.name != before.name, "Name"),
        (now.diameter_mm != before.diameter_mm, "Diameter"),
        (now.kind() != before.kind(), "Kind"),
        (now.corner_mm != before.corner_mm, "Corner"),
        (now.reach_mm != before.reach_mm, "Reach"),
    ];
    let name = what.iter().find(|(differs, _)| *differs).map_or("Holder", |(_, name)| name);
    format!("{name} of cutter {}", i + 1)
}

/// The same of electrodes.
fn change_of_electrodes(now: &ElectrodeParams, before: &ElectrodeParams) -> String {
    if now.edits.len() < before.edits.len() {
        return "Removal of a change".to_owned();
    }
    if now.edits != before.edits {
        let name = match now.edits.last() {
            Some(Edit::Merge { .. }) => "Merged parts",
            Some(Edit::Split { .. }) => "Split part",
            Some(Edit::Burn { .. }) => "Burn direction",
            _ => "Method of a region",
        };
        return name.to_owned();
    }
    if let Some(new) = now.overrides.iter().find(|o| !before.overrides.contains(o)) {
        return format!("Override of {}", new.electrode);
    }
    if now.overrides != before.overrides {
        return "Override taken back".to_owned();
    }
    match now.stages.len().cmp(&before.stages.len()) {
        std::cmp::Ordering::Greater => return "New stage".to_owned(),
        std::cmp::Ordering::Less => return "Removal of a stage".to_owned(),
        std::cmp::Ordering::Equal => {}
    }
    let what = [
        (now.stages != before.stages, "Stage"),
        (now.margin_mm != before.margin_mm, "Side extension"),
        (now.overlap_mm != before.overlap_mm, "Overlap of parts"),
        (now.least_size_mm != before.least_size_mm, "Least size"),
        (now.tolerance_mm != before.tolerance_mm, "Allowed rest"),
        (now.extension_mm != before.extension_mm, "Clearance above mold"),
        (now.base_height_mm != before.base_height_mm, "Base height"),
        (now.base_margin_mm != before.base_margin_mm, "Base margin"),
        (now.datum_corner_mm != before.datum_corner_mm, "Orientation chamfer"),
        (now.share != before.share, "Reuse at identical places"),
        (now.together_mm != before.together_mm, "Group within"),
        (now.family != before.family, "Stages on one base"),
        (now.family_spacing_mm != before.family_spacing_mm, "Distance between stages"),
        (now.lift_mm != before.lift_mm, "Retract distance"),
        (now.shape != before.shape, "Export with or without spark gap"),
        (now.material != before.material, "Material"),
        (now.holders != before.holders, "Holders"),
        (now.blanks != before.blanks, "Blanks"),
        (now.cutters != before.cutters, "Cutters for electrodes"),
        (now.removal != before.removal, "Burning times"),
    ];
    what.iter().find(|(differs, _)| *differs).map_or("Electrodes", |(_, name)| name).to_owned()
}

#[cfg(test)]
mod tests {
    use super::*;
    use files::Document;
    use mold::cutter::Cutter;

    #[test]
    fn a_mold_is_read_as_it_was_written_and_finds_its_mesh_beside_it() {
        let folder = tempfile::tempdir().unwrap();
        let [here, there] = ["here", "there"].map(|name| folder.path().join(name));
        [&here, &there].into_iter().for_each(|f| std::fs::create_dir(f).unwrap());
        let mut params = MoldParams { mesh: Some(here.join("part.stl")), ..MoldParams::default() };
        (params.opening, params.tolerance_mm) = (Opening::MinusX, 0.05);
        params.electrodes.edits.push(Edit::Split { line: [glam::DVec3::X, glam::DVec3::Y] });
        params.electrodes.overrides.push("E01:gouge".parse().unwrap());
        params.library.cutter.push(Cutter { reach_mm: Some(12.0), ..Cutter::bull_nose(3.0, 0.5) });
        let file = here.join("part.sparkpath");
        Document::new(params.clone()).export(&file).unwrap();
        let read = |file: &Path| Document::<MoldParams>::open(file).unwrap().params().clone();
        assert_eq!(read(&file), params);
        let short = here.join("short.sparkpath");
        std::fs::write(&short, "kind = \"mold\"\n[electrodes]\noverrides = [\"E03\"]").unwrap();
        let MoldParams { electrodes, .. } = read(&short);
        assert!(electrodes.overrides[0].electrode == "E03" && electrodes.overrides[0].check.is_none());
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
            ("tolerance_mm = nan", "tolerance_mm is NaN"),
            ("opening = \"up\"", "unknown variant"),
            ("[[library.cutter]]\ndiameter_mm = 0", "line 3: library.cutter[0].diameter_mm is 0"),
            ("library = {}", "no cutter"),
            ("tolerance = 1", "unknown field"),
            ("[electrodes]\nmargin_mm = -1", "line 3: electrodes.margin_mm is -1"),
        ] {
            std::fs::write(&file, format!("kind = \"mold\"\n{text}")).unwrap();
            let said = Document::<MoldParams>::open(&file).unwrap_err().to_string();
            assert!(said.contains("wrong.sparkpath") && said.contains(words), "{text}: {said}");
        }
        let broken = MoldParams { tolerance_mm: 0.0, ..MoldParams::default() };
        assert!(Document::new(broken).export(&file).is_err());
    }
}
