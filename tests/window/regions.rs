//! Parts of uncut regions in the workspace of molds: merged, and split along a drawn line.

use egui::{Key, Modifiers, Role};
use egui_kittest::kittest::{By, Queryable as _};
use files::AnyDocument as _;
use geometry::mesh::Mesh;
use geometry::solid::{difference, prism};
use glam::{DVec2, DVec3};
use import::write_stl;
use mold::cutter::{Cutter, CutterLibrary};
use sparkpath::shell::run::Opening;

use crate::desk::{Desk, Home};
use crate::electrodes::{click_at, until_designed};

/// A block of 20 x 20 x 10 mm with a slot of 3 mm, 4 mm deep, that goes round a corner: no cutter makes the inner edge that
/// its electrode would have.
pub(crate) fn bent_slot() -> Mesh {
    let outline = |points: &[[f64; 2]]| points.iter().copied().map(DVec2::from).collect::<Vec<_>>();
    let block = outline(&[[-10.0, -10.0], [10.0, -10.0], [10.0, 10.0], [-10.0, 10.0]]);
    let slot = outline(&[[-6.0, -6.0], [6.0, -6.0], [6.0, -3.0], [-3.0, -3.0], [-3.0, 6.0], [-6.0, 6.0]]);
    difference(&prism(&[&block], 0.0, 10.0).unwrap(), &prism(&[&slot], 6.0, 11.0).unwrap()).unwrap()
}

/// A window on the bent slot with its electrodes.
pub(crate) fn with_electrodes(home: &Home, pixels: [u16; 2]) -> Desk {
    let file = home.path("bent.stl");
    write_stl(&file, &bent_slot()).unwrap();
    let mut desk = home.start_in(Opening::In("mold", Some(file)), pixels, 1.0);
    desk.take_cutters(&[Cutter::flat(2.0)]);
    let mut params = desk.mold().document.params().clone();
    params.electrodes.cutters = Some(CutterLibrary { cutter: vec![Cutter::flat(0.5)] });
    desk.mold_mut().edit(params);
    desk.until_loaded();
    desk.press("Create electrodes");
    until_designed(&mut desk);
    desk
}

#[test]
fn two_parts_of_a_region_are_merged_and_one_is_split_along_a_drawn_line() {
    let home = Home::new();
    let mut desk = with_electrodes(&home, [1280, 720]);
    let parts = |desk: &Desk| desk.mold().electrodes.designed().unwrap().leaves(0).len();
    let until_made = |desk: &mut Desk| {
        desk.until("they are made again", |d| d.mold().is_designed() && !d.mold().work.is_busy());
        assert!(desk.mold().electrodes.designed().unwrap().set.unmet_edits().is_empty());
    };
    assert_eq!(parts(&desk), 2);
    let select = |desk: &mut Desk| {
        let name = desk.mold().electrodes.designed().unwrap().set.electrodes[0].name.clone();
        desk.press_role(Role::Row, &format!("Electrode {name}"));
    };
    select(&mut desk);
    desk.press("part R1.1");
    desk.press("part R1.2");
    let [part, merge] = ["part R1.2", "Merge the two parts"]
        .map(|name| desk.window.get(By::new().role(Role::Button).label(name)).rect());
    let below = merge.top() - part.bottom();
    assert!((0.0..12.0).contains(&below), "merging is offered where the hand is: {below} points below");
    desk.press("Merge the two parts");
    assert_eq!(desk.mold().document.undo_label(false), Some("Merged parts"));
    until_made(&mut desk);
    assert_eq!(parts(&desk), 1);
    desk.key_with(Modifiers::COMMAND, Key::Z);
    until_made(&mut desk);
    assert_eq!(parts(&desk), 2);

    if desk.mold().electrodes.selected.is_none() {
        select(&mut desk);
    }
    desk.press("Split\u{2026}");
    desk.until("the view has turned", |d| d.app().camera().backward().z > 0.9999);
    for end in [DVec3::new(2.0, -7.5, 10.0), DVec3::new(2.0, -1.5, 10.0)] {
        click_at(&mut desk, end);
    }
    assert_eq!(desk.mold().document.undo_label(false), Some("Split part"));
    until_made(&mut desk);
    assert_eq!(parts(&desk), 3);
}
