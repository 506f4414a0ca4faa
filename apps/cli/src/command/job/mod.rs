//! `snowgrain job`.

mod plan;
mod sweep;

use crate::arguments::{
    Arguments, Command, JobArguments, JobKind, PlanArguments, RenderArguments, RunArguments,
    StatusArguments,
};
use crate::failure::{Failure, exit};
use crate::output;
use clap::Parser;
use plan::{Job, Task};
use snowgrain_formats::{FormatsError, atomic, film_summary};
use std::ffi::OsString;
use std::path::Path;

pub(super) fn run(arguments: &JobArguments) -> Result<u8, Failure> {
    match &arguments.kind {
        JobKind::Plan(arguments) => write(arguments),
        JobKind::Run(arguments) => run_task(arguments),
        JobKind::Status(arguments) => status(arguments),
    }
}

fn write(arguments: &PlanArguments) -> Result<u8, Failure> {
    let points = match &arguments.sweep {
        Some(path) => sweep::read(path)?,
        None => vec![Vec::new()],
    };
    let job = Job {
        version: Job::VERSION,
        scene: scene(arguments)?,
        options: options(arguments),
        samples: arguments.samples,
        per_task: arguments.per_task,
        frames: arguments.frames.as_ref().map(|frames| [*frames.start(), *frames.end()]),
        points,
    };
    let Some(tasks) = job.tasks() else {
        return Err(Failure::usage("the job has more tasks than can be counted; make it smaller"));
    };
    let path = &arguments.output;
    atomic::check_writable_target(path)?;
    refuse_parts_of_another(path, &job)?;
    job.tasks_of_every_value().try_for_each(|task| {
        super::render::recipes(&render_arguments(&job, path, &task)?).map(|_| ())
    })?;
    output::write_text(path, &output::json(&job)?)?;
    let file = arguments.output.display();
    output::tell(&format!("snowgrain: {file}: tasks 0 to {} (job run {file} --task K)", tasks - 1));
    Ok(0)
}

/// Refuses to replace a job of which there are films by another job.
fn refuse_parts_of_another(path: &Path, job: &Job) -> Result<(), Failure> {
    let folder = Job::parts_folder(path);
    let is_empty = std::fs::read_dir(&folder).map_or(true, |mut films| films.next().is_none());
    if is_empty || Job::read(path).is_ok_and(|there| there == *job) {
        return Ok(());
    }
    let what = format!(
        "{} holds films of another job of this name; name another file, or remove that folder",
        folder.display()
    );
    Err(Failure::usage(what).of(&path.display().to_string()))
}

/// The scene as the job names it: a file relative to the job's folder, where that can be told.
fn scene(arguments: &PlanArguments) -> Result<String, Failure> {
    let path = &arguments.scene.scene;
    let relative = match (std::path::absolute(path), std::path::absolute(&arguments.output)) {
        (Ok(scene), Ok(job)) if path.extension().is_some() => match job.parent() {
            Some(folder) => scene.strip_prefix(folder).map(Path::to_path_buf).unwrap_or(scene),
            None => scene,
        },
        _ => path.clone(),
    };
    let text = relative.into_os_string().into_string();
    text.map_err(|_| Failure::usage("the path of the scene is not UTF-8; rename it"))
}

/// What every render of the job is told.
fn options(arguments: &PlanArguments) -> Vec<String> {
    let PlanArguments { scene, seed, size, .. } = arguments;
    let mut options = Vec::new();
    let mut add = |option: &str, value: String| options.extend([option.to_owned(), value]);
    scene.overrides.iter().for_each(|set| add("--set", set.clone()));
    scene.units.iter().for_each(|units| add("--units", units.name().into()));
    scene.up.iter().for_each(|up| add("--up", up.name().into()));
    scene.object_size.iter().for_each(|size| add("--object-size", size.to_string()));
    scene.kind.iter().for_each(|kind| add("--kind", kind.name().into()));
    seed.iter().for_each(|seed| add("--seed", seed.to_string()));
    size.iter().for_each(|size| add("--size", format!("{}x{}", size.width, size.height)));
    options
}

fn run_task(arguments: &RunArguments) -> Result<u8, Failure> {
    let path = &arguments.job;
    let job = Job::read(path)?;
    let Some(task) = job.task(arguments.task) else {
        return Err(Failure::usage(match job.tasks() {
            Some(count) if count > 0 => format!("the job has tasks 0 to {}", count - 1),
            _ => "the job has no tasks".into(),
        }));
    };
    let folder = Job::parts_folder(path);
    std::fs::create_dir_all(&folder).map_err(|error| {
        let message = format!("{}: cannot be created: {error}", folder.display());
        Failure::new(exit::CANNOT_CREATE, message)
    })?;
    let mut render = render_arguments(&job, path, &task)?;
    render.report.quiet = arguments.quiet;
    render.machine = arguments.machine.clone();
    super::render::run(&render)
}

/// The render that a task is.
fn render_arguments(job: &Job, path: &Path, task: &Task) -> Result<RenderArguments, Failure> {
    let mut typed: Vec<OsString> = vec!["snowgrain".into(), "render".into()];
    typed.push(job.scene_path(path).into());
    typed.extend(job.options.iter().map(OsString::from));
    for set in &job.points[task.point] {
        typed.extend(["--set".into(), set.into()]);
    }
    let Task { samples, frame, .. } = task;
    typed.extend(["--samples".into(), format!("{}..{}", samples.start, samples.end).into()]);
    if let Some(frame) = frame {
        typed.extend(["--frame".into(), frame.to_string().into()]);
    }
    let film = Job::parts_folder(path).join(task.file_name());
    typed.extend(["--resume".into(), "-o".into(), film.into()]);
    let parsed = Arguments::try_parse_from(typed).map_err(|error| {
        let what = error.to_string();
        let line = what.lines().next().unwrap_or_default();
        Failure::bad_input(format!("{}: its options mean nothing: {line}", path.display()))
    })?;
    match parsed.command {
        Command::Render(render) => Ok(*render),
        _ => unreachable!("what begins with render is a render"),
    }
}

/// What became of a task.
enum State {
    Done,
    Missing,
    /// Some of its samples are there.
    Begun,
    /// The film is that of another scene.
    Foreign,
    Damaged(FormatsError),
}

/// `recipes` tells the digests that films of the task may have.
fn state(
    folder: &Path,
    task: &Task,
    recipes: impl FnOnce() -> Result<[[u8; 32]; 2], Failure>,
) -> Result<State, Failure> {
    Ok(match film_summary(&folder.join(task.file_name())) {
        Ok(film) if !recipes()?.iter().any(|&recipe| film.recipe == Some(recipe)) => State::Foreign,
        Ok(film) if film.samples.missing_from(task.samples.clone()).is_empty() => State::Done,
        Ok(_) => State::Begun,
        Err(FormatsError::Missing { .. }) => State::Missing,
        Err(error) => State::Damaged(error),
    })
}

fn status(arguments: &StatusArguments) -> Result<u8, Failure> {
    let job = Job::read(&arguments.job)?;
    let folder = Job::parts_folder(&arguments.job);
    let count = job.tasks().unwrap_or(0);
    let (mut done, mut lines) = (0, String::new());
    // Tasks of one picture follow one another.
    let mut known = None;
    for number in 0..count {
        let Some(task) = job.task(number) else { break };
        let picture = (task.point, task.frame);
        let recipes = || match known {
            Some((of, recipes)) if of == picture => Ok(recipes),
            _ => {
                let arguments = render_arguments(&job, &arguments.job, &task)?;
                let (_, recipes) = *known.insert((picture, super::render::recipes(&arguments)?));
                Ok(recipes)
            }
        };
        let said = match state(&folder, &task, recipes)? {
            State::Done => {
                done += 1;
                continue;
            }
            State::Missing => "missing".to_owned(),
            State::Begun => "begun".to_owned(),
            State::Foreign => {
                "of another scene or seed, or of another version of Snowgrain; remove its film"
                    .to_owned()
            }
            State::Damaged(error) => format!("damaged ({error})"),
        };
        let Task { point, frame, samples } = task;
        let frame = frame.map_or_else(String::new, |frame| format!(" frame {frame}"));
        let (start, end) = (samples.start, samples.end);
        lines += &format!("task {number}: point {point}{frame} samples {start}..{end} {said}\n");
    }
    output::print(&lines)?;
    output::tell(&format!("snowgrain: {done} of {count} tasks are finished"));
    Ok(if done == count { 0 } else { exit::INCOMPLETE })
}
