//! The solids of an assembly, each with the places at which it stands.

use std::collections::HashMap;

use glam::{DMat4, DVec4};
use step_io::Orientation;
use step_io::model::EntityKey;
use step_io::scene::{Face, MappedInstance, ProductDef, Scene, Shell, Solid};

use crate::error::StepError;

/// A solid and its places.
pub(super) struct Placed<'m> {
    /// Name of the part and the solid.
    pub name: String,
    /// Colour of the solid.
    pub color: Option<[f32; 3]>,
    /// Faces, and whether their shell is used turned over.
    pub faces: Vec<(Face<'m>, bool)>,
    /// From the axes of the solid to those of the assembly, in the unit of the file.
    pub places: Vec<DMat4>,
}

/// Assemblies within assemblies are followed so far.
const DEEPEST: usize = 40;

/// All solids, and closed surfaces where a part has no solid.
///
/// # Errors
/// [`StepError::TooLarge`] for more than `most` of them.
pub(super) fn placed<'m>(scene: &'m Scene<'m>, most: u64) -> Result<Vec<Placed<'m>>, StepError> {
    let mut list = List { all: Vec::new(), of_key: HashMap::new(), count: 0, most };
    for root in scene.root_definitions() {
        list.definition(root, DMat4::IDENTITY, 0)?;
    }
    for mapped in scene.all_mapped_instances() {
        list.mapped(mapped, "", DMat4::IDENTITY)?;
    }
    // Solids of files that list them outside all products.
    for solid in scene.all_solids() {
        if !list.of_key.contains_key(&solid.key()) {
            list.solid(solid, "", DMat4::IDENTITY)?;
        }
    }
    Ok(list.all)
}

struct List<'m> {
    all: Vec<Placed<'m>>,
    of_key: HashMap<EntityKey, usize>,
    count: u64,
    most: u64,
}

impl<'m> List<'m> {
    fn definition(&mut self, def: ProductDef<'m>, at: DMat4, depth: usize) -> Result<(), StepError> {
        let name = def.product().map_or("", |p| p.name());
        let mut has_solids = false;
        for solid in def.solids() {
            has_solids = true;
            self.solid(solid, name, at)?;
        }
        if !has_solids {
            for surface in def.surface_models() {
                for (shell, orientation) in surface.shells() {
                    self.shell(shell, orientation == Orientation::Forward, name, at)?;
                }
            }
        }
        if depth < DEEPEST {
            for occurrence in def.occurrences() {
                let Some(child) = occurrence.definition() else { continue };
                let to = occurrence.transform().and_then(|t| t.matrix()).map_or(DMat4::IDENTITY, matrix);
                self.definition(child, at * to, depth + 1)?;
            }
        }
        Ok(())
    }

    fn mapped(&mut self, mapped: MappedInstance<'m>, name: &str, at: DMat4) -> Result<(), StepError> {
        let to = mapped.transform().and_then(|t| t.matrix()).map_or(DMat4::IDENTITY, matrix);
        for solid in mapped.solids() {
            self.solid(solid, name, at * to)?;
        }
        Ok(())
    }

    fn solid(&mut self, solid: Solid<'m>, name: &str, at: DMat4) -> Result<(), StepError> {
        let shells = solid.outer().into_iter().chain(solid.voids());
        let faces = shells.flat_map(|(shell, o)| shell.faces().map(move |f| (f, o == Orientation::Reversed))).collect();
        let color = solid.color().or_else(|| solid.outer().and_then(|(shell, _)| shell.color()));
        self.add(solid.key(), joined(name, solid.name()), color.map(rgb), faces, at)
    }

    fn shell(&mut self, shell: Shell<'m>, is_forward: bool, name: &str, at: DMat4) -> Result<(), StepError> {
        let faces = shell.faces().map(|f| (f, !is_forward)).collect();
        self.add(shell.key(), joined(name, shell.name()), shell.color().map(rgb), faces, at)
    }

    fn add(
        &mut self,
        key: EntityKey,
        name: String,
        color: Option<[f32; 3]>,
        faces: Vec<(Face<'m>, bool)>,
        at: DMat4,
    ) -> Result<(), StepError> {
        self.count += 1;
        if self.count > self.most {
            return Err(StepError::TooLarge { what: "solids", found: self.count, limit: self.most });
        }
        let n = *self.of_key.entry(key).or_insert(self.all.len());
        match self.all.get_mut(n) {
            Some(placed) => placed.places.push(at),
            None => self.all.push(Placed { name, color, faces, places: vec![at] }),
        }
        Ok(())
    }
}

fn rgb(c: step_io::scene::Rgb) -> [f32; 3] {
    [c.red as f32, c.green as f32, c.blue as f32]
}

/// Name of a solid within its part.
fn joined(part: &str, solid: &str) -> String {
    match (part.trim(), solid.trim()) {
        ("", "") => "solid".to_owned(),
        (part, "") => part.to_owned(),
        ("", solid) => solid.to_owned(),
        (part, solid) if part == solid => part.to_owned(),
        (part, solid) => format!("{part}: {solid}"),
    }
}

fn matrix(rows: [[f64; 4]; 4]) -> DMat4 {
    DMat4::from_cols(DVec4::from(rows[0]), DVec4::from(rows[1]), DVec4::from(rows[2]), DVec4::from(rows[3])).transpose()
}
