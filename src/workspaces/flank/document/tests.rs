use super::*;
use crate::workspaces::flank::document::kept_mesh::KeptMesh;
use files::Document;
use files::Override;
use flank::guide::GuideCurve;
use flank::params::Objective;
use geometry::mesh::Mesh;

fn opened(file: &Path) -> FlankDocument {
    Document::<FlankDocument>::open(file).unwrap().params().clone()
}

#[test]
fn a_flank_is_read_as_it_was_written_and_finds_its_files_beside_it() {
    let folder = tempfile::tempdir().unwrap();
    let [here, there] = ["here", "there"].map(|name| folder.path().join(name));
    [&here, &there].into_iter().for_each(|f| std::fs::create_dir(f).unwrap());
    let curve = GuideCurve::Bezier { points: vec![glam::DVec3::X, glam::DVec3::Y] };
    let mesh = MeshFlank { file: here.join("part.stl"), candidate: 3, ..MeshFlank::default() };
    let part = Mesh::cuboid(glam::DVec3::new(1.0 / 3.0, 2.0, 40.0));
    let kept = KeptMesh::new("E01", "'''mold\"", &part).unwrap();
    let sources = [
        FlankSource::Demonstration { surface: DemonstrationSurface::B },
        FlankSource::Guides { lower: GuideSource::File(here.join("lower.csv")), upper: GuideSource::Curve(curve) },
        FlankSource::Mesh(mesh),
        FlankSource::Mesh(MeshFlank { kept: Some(kept), candidate: 2, ..MeshFlank::default() }),
    ];
    for source in sources {
        let mut document = FlankDocument { source, ..FlankDocument::default() };
        document.plan.objective = Objective::Bounded { overcut_mm: Some(0.0), undercut_mm: None };
        document.walls = Some(WallsFile { file: here.join("walls.obj"), units: Default::default() });
        document.overrides.push(Override::whatever("envelope"));
        document.overrides.push(Override::decided(
            "gouge",
            vec!["digest".to_owned()],
            &[("depth_mm".to_owned(), 0.12)].into(),
        ));
        document.milling.machine = here.join("ours.toml").to_string_lossy().into_owned();
        let file = here.join("part.sparkpath");
        Document::new(document.clone()).export(&file).unwrap();
        assert_eq!(opened(&file), document);
        std::fs::copy(&file, there.join("copy.sparkpath")).unwrap();
        assert_eq!(opened(&there.join("copy.sparkpath")).walls.unwrap().file, there.join("walls.obj"));
        assert!(!std::fs::read_to_string(&file).unwrap().contains(&*folder.path().to_string_lossy()));
    }
    let short = here.join("short.sparkpath");
    std::fs::write(&short, "kind = \"flank\"").unwrap();
    assert_eq!(opened(&short), FlankDocument::default());
}

#[test]
fn what_is_no_flank_is_answered_with_the_place_and_the_reason() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("wrong.sparkpath");
    for (text, words) in [
        ("side = \"up\"", "unknown variant"),
        ("[cutter]\nradius_mm = -1\nlength_mm = 20", "radius_mm is -1"),
        ("[cutter]\nradius_mm = 1\nlength_mm = 20\ntaper_deg = 60", "taper_deg is 60"),
        ("[plan]\ngrid = [1, 50]", "grid is 1"),
        ("[plan]\nlocations = 5", "locations is 5"),
        ("[milling]\nlinearisation_mm = nan", "linearisation_mm is nan"),
        ("[milling]\nretract_mm = -1", "retract_mm is -1"),
        ("[milling]\npost = \"nobody's\"", "nobody's"),
        ("[milling.program]\nfeed_mm_per_min = 0", "feed_mm_per_min is 0"),
        ("[source]\nkind = \"mesh\"\nfile = \"a.stl\"\ncandidate = 0", "candidate is 0"),
        ("[source]\nkind = \"sphere\"", "unknown variant"),
        ("[source]\nkind = \"guides\"\nlower = { file = \"a.csv\" }", "missing field `upper`"),
        ("envelope_tolerance_mm = 0", "envelope_tolerance_mm is 0"),
        ("tolerance = 1", "unknown field"),
        ("overrides = [{ check = \"gouge\", figures = { depth_mm = -1.0 } }]", "override of gouge: a figure is -1"),
        ("overrides = [\"gouge:1x\"]", "\"1x\" is no figure"),
        ("overrides = [7]", "expected the name of a check"),
        ("overrides = [\"gauge\"]", "there is no check \"gauge\"; there are ruled, guides"),
        ("overrides = [{ check = \"gouge\", figure = 1.0 }]", "unknown field"),
    ] {
        std::fs::write(&file, format!("kind = \"flank\"\n{text}")).unwrap();
        let said = Document::<FlankDocument>::open(&file).unwrap_err().to_string();
        assert!(said.contains("wrong.sparkpath") && said.contains(words), "{text}: {said}");
    }
    let broken = FlankDocument { envelope_tolerance_mm: 0.0, ..FlankDocument::default() };
    assert!(Document::new(broken).export(&file).is_err());
}

#[test]
fn another_machine_forgets_how_workpiece_and_tool_were_on_the_former_one() {
    let mut milling = FlankDocument::default().milling;
    let machine = milling.machine.clone();
    (milling.workpiece, milling.gauge_length_mm) = (Some(Default::default()), Some(125.0));
    let clamped = milling.clone();
    assert_eq!((milling.take_machine(&machine), &milling), (None, &clamped), "it is the same");
    let said = milling.take_machine("fork-cb").unwrap();
    assert!(said.contains("clamped") && said.contains("gauge length"), "{said}");
    assert_eq!((milling.workpiece.clone(), milling.gauge_length_mm, &*milling.machine), (None, None, "fork-cb"));
    assert_eq!((milling.take_machine(&machine), milling.machine), (None, machine), "there is nothing to forget");
}
