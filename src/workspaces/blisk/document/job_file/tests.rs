use super::*;
use crate::workspaces::blisk::document::Document;
use feed::axis_curve::Joining;
use feed::machine::AxisSet;
use files::AnyDocument as _;

/// The parameters in a project that lies in `folder`.
fn parse_in(folder: &Path, text: &str) -> Result<PlanJob, String> {
    let text = format!("kind = \"blisk\"\n{text}");
    Document::parse(&text, folder).map(|document| document.params().clone()).map_err(|e| e.to_string())
}

fn parse(text: &str) -> Result<PlanJob, String> {
    parse_in(Path::new("/jobs"), text)
}

fn problem(job: &PlanJob) -> String {
    job.validate().unwrap_err().to_string()
}

#[test]
fn a_mesh_is_all_a_job_needs() {
    let job = parse("[blisk]\nmesh = \"part.stl\"").unwrap();
    let demonstration = PlanJob::demonstration();
    assert_eq!(job.blisk.mesh.as_deref(), Some(Path::new("/jobs/part.stl")));
    assert_eq!(job, PlanJob::for_mesh(Path::new("/jobs/part.stl")));
    assert_eq!(job.plan.strategy, Strategy::Global);
    assert_eq!(
        (job.plan, job.genetic, job.machine),
        (demonstration.plan, demonstration.genetic, demonstration.machine)
    );
}

#[test]
fn the_keys_of_the_contract_are_understood() {
    let job = parse(
        r#"
        [blisk]
        mesh = "part.stl"
        units = "mm"
        axis = "auto"
        blades = "auto"
        channel = 0
        hub_radius_mm = "auto"
        shroud_radius_mm = 125.0
        [electrode]
        spark_gap_mm = 0.10
        circumferential_reduction_deg = [0.8, 0.9]
        radial_reduction_mm = 0.5
        parts = 1
        overlap_mm = 1.0
        enter = "-x"
        size = "given"
        [machine]
        axes = "XYZAC"
        [plan]
        strategy = "genetic"
        step_mm = 0.5
        exit_clearance_mm = 5.0
        margin_mm = 0.0
        [plan.weights]
        a3 = 0.5
        b3 = 0.5
        [genetic]
        population = 30
        generations = 10
        crossover = 0.8
        mutation = 0.1
        seed = 7
        [verify]
        tolerance_mm = 0.002
        "#,
    )
    .unwrap();
    assert_eq!(job.electrode.circumferential_reduction_deg, [0.8, 0.9]);
    assert_eq!((job.genetic.seed, job.plan.weights.a3), (7, 0.5));
}

#[test]
fn a_job_may_follow_the_centreline_and_join_by_nurbs() {
    let text = "[blisk]\nmesh = \"a.stl\"\n[plan]\nstrategy = \"centreline\"\n[plan.centreline]\n\
                safety_increase_mm = 0.2\n[plan.interpolation]\nkind = \"nurbs\"\ndegree = 4";
    let mut job = parse(text).unwrap();
    assert_eq!((job.plan.strategy, job.plan.centreline.safety_increase_mm), (Strategy::Centreline, 0.2));
    assert_eq!(job.plan.interpolation.joining(), Joining::Nurbs(4));
    assert_eq!(job.validate(), Ok(()));
    job.genetic.h = ReductionMode::Variable;
    assert!(problem(&job).contains("genetic.h"));
}

#[test]
fn what_is_exported_can_be_said_and_is_everything_by_default() {
    let job = parse("[blisk]\nmesh = \"a.stl\"\n[export]\npost = \"beckhoff-edm\"").unwrap();
    assert_eq!(job.export, ExportSection { post: "beckhoff-edm".to_owned(), ..Default::default() });
    let text = "[blisk]\nmesh = \"a.stl\"\n[export]\nframe = \"w\"\n[export.files]\nnc = false\npictures = false\n\
                [export.pictures]\nsweep = false";
    let export = parse(text).unwrap().export;
    assert_eq!(export.frame, MeshFrame::W);
    assert_eq!(export.files, WrittenFiles { nc: false, pictures: false, ..Default::default() });
    assert!(export.pictures.final_pose && !export.pictures.sweep);
}

#[test]
fn a_project_finds_its_files_wherever_it_lies_and_says_what_was_chosen() {
    let folder = tempfile::tempdir().unwrap();
    let [parts, jobs] = ["parts", "jobs"].map(|name| folder.path().join(name));
    for folder in [&parts, &jobs] {
        std::fs::create_dir(folder).unwrap();
    }
    let [mesh, own, post, machine] = ["part.stl", "own.stl", "mine.toml", "mill.toml"].map(|name| parts.join(name));
    let mut job = PlanJob::for_mesh(&mesh);
    job.electrode.mesh = Some(own.clone());
    job.export = ExportSection { frame: MeshFrame::W, channels: Channels::These(vec![0, 3]), ..Default::default() };
    (job.export.files.nc, job.export.pictures.sweep) = (false, false);
    job.export.post = post.to_str().unwrap().to_owned();
    job.machine.name = machine.to_str().unwrap().to_owned();
    let file = jobs.join("job.sparkpath");
    Document::new(job.clone()).save_as(&file).unwrap();
    assert_eq!(*Document::open(&file).unwrap().params(), job);
    let text = std::fs::read_to_string(&file).unwrap();
    for path in ["part.stl", "own.stl", "mine.toml", "mill.toml"] {
        assert!(text.contains(&format!("\"../parts/{path}\"")), "{text}");
    }
    // All of it together elsewhere.
    let elsewhere = folder.path().join("elsewhere");
    std::fs::create_dir(&elsewhere).unwrap();
    std::fs::rename(&parts, elsewhere.join("parts")).unwrap();
    std::fs::rename(&jobs, elsewhere.join("jobs")).unwrap();
    let read = Document::open(&elsewhere.join("jobs/job.sparkpath")).unwrap();
    assert_eq!(read.params().blisk.mesh, Some(elsewhere.join("parts/part.stl")));
}

#[test]
fn an_export_of_nothing_is_refused_and_draws_nothing() {
    let mut job = PlanJob::demonstration();
    job.export.files = WrittenFiles {
        electrode: false,
        step: false,
        path: false,
        nc: false,
        report: false,
        residual_stock: false,
        pictures: false,
    };
    assert!(problem(&job).contains("export.files"));
    assert!(!job.export.draws_any());
    job.export.files.report = true;
    assert!(job.validate().is_ok() && job.export.draws_any(), "a page of the report holds pictures of its own");
}

#[test]
fn mistakes_are_named_with_their_place() {
    for (text, named) in [
        ("[blisk]\nmesh = \"a.stl\"\nblade = 3", "line 4: blisk.blade: unknown field `blade`"),
        ("[blisk]\nmesh = 7", "line 3: blisk.mesh"),
        ("[blisk]\nmesh = \"a.stl\"\n[plan]\nstep_mm = \"wide\"", "line 5: plan.step_mm: "),
        ("[blisk]\nmesh = \"a.stl\"\n[plan]\nstep_mm = 50", "line 5: plan.step_mm is 50"),
        ("[blisk]\nmesh = \"a.stl\"\n[genetics]\nseed = 2", "line 4: genetics: "),
        ("[blisk\nmesh = 1", "line 2"),
        ("blisk = 3", "blisk"),
    ] {
        let message = parse(text).unwrap_err();
        assert!(message.contains(named) && !message.contains('\n'), "{text:?}: {message}");
    }
}

#[test]
fn the_global_strategy_works_on_distances_alone() {
    let mut job = PlanJob::demonstration();
    assert_eq!((job.plan.strategy, job.validate()), (Strategy::Global, Ok(())));
    job.plan.constraint = Constraint::Angle;
    assert!(problem(&job).contains("works on distances"));
    job.plan.strategy = Strategy::Genetic;
    assert_eq!(job.validate(), Ok(()));
}

#[test]
fn a_machine_is_named_and_its_keys_may_be_given_otherwise() {
    let with = |machine: &str| parse(&format!("[blisk]\nmesh = \"a.stl\"\n[machine]\n{machine}"));
    let none = with("axes = \"XYZC\"").unwrap().machine;
    assert!(!none.has_bodies() && none.travel_x_mm == MachineParams::default().travel_x_mm);
    let job = with("name = \"xyzabc\"\ntravel_b_deg = [-10.0, 20.0]").unwrap();
    assert_eq!((job.machine.axes, job.machine.travel_b_deg), (AxisSet::XYZABC, [-10.0, 20.0]));
    assert!(job.machine.has_bodies() && job.machine.travel_c_deg == [-360.0, 360.0]);
    assert!(with("name = \"mill\"").unwrap_err().contains("there is no such machine"));
    assert!(with("name = \"my.step\"").unwrap_err().contains("there is no such machine"));
    assert!(with("name = \"my.toml\"").unwrap_err().contains("cannot be read"));
    let said = with("name = \"xyzc\"\nbody_clearance_mm = 0.0").unwrap_err();
    assert!(said.contains("line 6: machine.body_clearance_mm is 0"), "{said}");
}

#[test]
fn a_machine_file_is_found_from_the_project_and_a_saved_one_can_do_without() {
    let folder = tempfile::tempdir().unwrap();
    let machine = folder.path().join("my.toml");
    std::fs::write(&machine, "axes = \"XYZC\"\ntravel_z_mm = [-7.0, 8.0]\nspeed_mm_min = 30.0\n").unwrap();
    let text = "[blisk]\nmesh = \"a.stl\"\n[machine]\nname = \"my.toml\"\nspeed_mm_min = 20.0";
    let job = parse_in(folder.path(), text).unwrap();
    let m = &job.machine;
    assert_eq!((m.axes, m.travel_z_mm, m.speed_mm_min), (AxisSet::XYZC, [-7.0, 8.0], 20.0));
    assert_eq!(Path::new(&m.name), machine);
    let file = folder.path().join("job.sparkpath");
    Document::new(job.clone()).save_as(&file).unwrap();
    // Mistakes are told of the file that they are in.
    for (mistake, words) in
        [("speed_deg_min = -1", "speed_deg_min"), ("travel_x_mm = 3", "travel_x_mm"), ("[a", "line 1")]
    {
        std::fs::write(&machine, mistake).unwrap();
        let said = parse_in(folder.path(), text).unwrap_err();
        assert!(said.contains("my.toml: ") && said.contains(words), "{said}");
    }
    // It says everything itself, and so can be read without the machine's file.
    std::fs::remove_file(&machine).unwrap();
    assert_eq!(Document::open(&file).unwrap().params().machine, job.machine);
}

#[test]
fn blades_are_given_by_sections_or_by_a_profile_instead_of_a_mesh() {
    let read = |text: &str| parse(&format!("[blisk]\nchannel = 0\n[blisk.sections]\n{text}"));
    let measured = read("kind = \"measured\"\nfile = \"blade.csv\"\nring = { blades = 24 }").unwrap();
    let BladesFrom::Measured(blades) = &measured.blisk.sections else { panic!("{:?}", measured.blisk) };
    assert_eq!((blades.ring.blades, measured.part().as_str()), (24, "blade.csv"));
    assert_eq!(measured.blisk.file(), Some(blades.file.as_path()));
    let profile = read("kind = \"profile\"\nblades = 12\nchord_mm = 14.0").unwrap();
    let BladesFrom::Profile(blisk) = &profile.blisk.sections else { panic!("{:?}", profile.blisk) };
    assert_eq!((blisk.blades, blisk.chord_mm), (12, 14.0));
    for (text, said) in [
        ("kind = \"measured\"", "blisk.sections.file"),
        (
            "kind = \"measured\"\nfile = \"a.csv\"\nring = { bore_radius_mm = 200.0 }",
            "blisk.sections.ring.bore_radius_mm",
        ),
        ("kind = \"profile\"\nchord = 3", "chord"),
        ("kind = \"profile\"\nblades = 500", "neighbouring blades"),
    ] {
        let error = read(text).unwrap_err();
        assert!(error.contains(said), "{text}: {error}");
    }
    let both = parse("[blisk]\nmesh = \"a.stl\"\n[blisk.sections]\nkind = \"profile\"").unwrap_err();
    assert!(both.contains("there is a mesh too"), "{both}");
}
