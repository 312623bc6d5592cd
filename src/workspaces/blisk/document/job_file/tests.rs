use super::*;
use feed::axis_curve::Joining;
use feed::machine::AxisSet;

fn parse(text: &str) -> Result<PlanJob, String> {
    PlanJob::parse(text, Path::new("jobs/job.toml")).map_err(|e| e.to_string())
}

#[test]
fn a_mesh_is_all_a_job_needs() {
    let job = parse("[blisk]\nmesh = \"part.stl\"").unwrap();
    let demonstration = PlanJob::demonstration();
    assert_eq!(job.blisk.mesh.as_deref(), Some(Path::new("jobs/part.stl")));
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
    assert!(job.validate().unwrap_err().contains("[genetic] h"));
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
    // What is chosen in the window comes back from a job file of it.
    let mut job = PlanJob::demonstration();
    (job.blisk.mesh, job.export) = (Some("jobs/a.stl".into()), export);
    let again = PlanJob::parse(&job.to_toml(Path::new("")).unwrap(), Path::new("job.toml")).unwrap();
    assert_eq!(again, job);
}

#[test]
fn a_job_file_finds_its_meshes_wherever_it_lies() {
    let folder = tempfile::tempdir().unwrap();
    let [parts, jobs] = ["parts", "jobs"].map(|name| folder.path().join(name));
    for folder in [&parts, &jobs] {
        std::fs::create_dir(folder).unwrap();
    }
    let [mesh, own, post] = ["part.stl", "own.stl", "mine.toml"].map(|name| parts.join(name));
    for file in [&mesh, &own, &post] {
        std::fs::write(file, "").unwrap();
    }
    let mut job = PlanJob::demonstration();
    (job.blisk.mesh, job.electrode.mesh) = (Some(mesh.clone()), Some(own.clone()));
    job.export.post = post.to_str().unwrap().to_owned();
    let file = jobs.join("job.toml");
    std::fs::write(&file, job.to_toml(&jobs).unwrap()).unwrap();
    let read = PlanJob::read(&file).unwrap();
    let same = |read: &Path, meant: &Path| read.canonicalize().unwrap() == meant.canonicalize().unwrap();
    assert!(same(&read.blisk.mesh.unwrap(), &mesh) && same(&read.electrode.mesh.unwrap(), &own));
    assert!(same(Path::new(&read.export.post), &post));
    assert!(PlanJob::demonstration().to_toml(&jobs).is_err(), "it would be a job that is refused");
    // A path as the command line gave it is seen from the working folder.
    job.blisk.mesh = Some("Cargo.toml".into());
    std::fs::write(&file, job.to_toml(&jobs).unwrap()).unwrap();
    assert!(same(&PlanJob::read(&file).unwrap().blisk.mesh.unwrap(), Path::new("Cargo.toml")));
}

#[test]
fn an_export_of_nothing_is_refused_and_draws_nothing() {
    let mut job = PlanJob::demonstration();
    job.export.files =
        WrittenFiles { electrode: false, path: false, nc: false, report: false, leftover: false, pictures: false };
    assert!(job.validate().unwrap_err().contains("[export.files]"));
    assert!(!job.export.draws_any());
    job.export.files.report = true;
    assert!(job.validate().is_ok() && job.export.draws_any(), "a page of the report holds pictures of its own");
}

#[test]
fn mistakes_are_named_with_their_place() {
    for (text, named) in [
        ("[blisk]\n", "mesh"),
        ("[blisk]\nmesh = \"a.stl\"\nblade = 3", "blade"),
        ("[blisk]\nmesh = 7", "line 2: blisk.mesh"),
        ("[blisk]\nmesh = \"a.stl\"\n[plan]\nstep_mm = \"wide\"", "line 3: plan: "),
        ("[blisk]\nmesh = \"a.stl\"\n[genetics]\nseed = 2", "line 3: genetics: "),
        ("[blisk\nmesh = 1", "line 1"),
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
    assert!(job.validate().unwrap_err().contains("works on distances"));
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
    assert!(with("name = \"xyzc\"\nfile = \"my.toml\"").unwrap_err().contains("two machines"));
    assert!(with("file = \"my.step\"").unwrap_err().contains("machine.file"));
    assert!(with("file = \"my.toml\"").unwrap_err().contains("cannot be read"));
    let job = with("name = \"xyzc\"\nbody_clearance_mm = 0.0").unwrap();
    assert!(job.validate().unwrap_err().contains("body_clearance_mm"));
}

#[test]
fn a_machine_file_is_found_from_the_job_and_written_for_its_folder() {
    let folder = tempfile::tempdir().unwrap();
    let machine = folder.path().join("my.toml");
    std::fs::write(&machine, "axes = \"XYZC\"\ntravel_z_mm = [-7.0, 8.0]\nspeed_mm_min = 30.0\n").unwrap();
    let text = "[blisk]\nmesh = \"a.stl\"\n[machine]\nfile = \"my.toml\"\nspeed_mm_min = 20.0";
    let job = PlanJob::parse(text, &folder.path().join("job.toml")).unwrap();
    let m = &job.machine;
    assert_eq!((m.axes, m.travel_z_mm, m.speed_mm_min), (AxisSet::XYZC, [-7.0, 8.0], 20.0));
    assert_eq!(Path::new(&m.name), machine);
    let written = job.to_toml(folder.path()).unwrap();
    assert!(written.contains("name = \"my.toml\""), "{written}");
    // Mistakes are told of the file that they are in.
    for (mistake, words) in
        [("speed_deg_min = -1", "speed_deg_min"), ("travel_x_mm = 3", "travel_x_mm"), ("[a", "line 1")]
    {
        std::fs::write(&machine, mistake).unwrap();
        let said = PlanJob::parse(text, &folder.path().join("job.toml")).unwrap_err().to_string();
        assert!(said.contains("my.toml: ") && said.contains(words), "{said}");
    }
    // It says everything itself, and so can be read without the machine's file.
    std::fs::remove_file(&machine).unwrap();
    let again = PlanJob::parse(&written, &folder.path().join("job.toml")).unwrap();
    assert_eq!(again.machine, job.machine);
}
