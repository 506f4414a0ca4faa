//! What a job consists of.

use crate::failure::{Failure, exit};
use serde::{Deserialize, Serialize};
use std::collections::HashSet;
use std::io::{self, ErrorKind};
use std::ops::Range;
use std::path::{Path, PathBuf};

/// Version of the format of jobs.
const VERSION: u32 = 1;

/// Most bytes of a job file that are read.
const MOST_BYTES: u64 = 1 << 28;

/// A job: pictures (points of a sweep, and frames of each), each cut into tasks by its samples.
#[derive(Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct Job {
    pub(super) version: u32,
    /// The scene as the user named it, a file relative to the job's folder.
    pub(super) scene: String,
    /// Options of each render.
    pub(super) options: Vec<String>,
    /// Samples of each pixel, and of each pixel in a task.
    pub(super) samples: u64,
    pub(super) per_task: u64,
    /// First and last frame.
    pub(super) frames: Option<[u32; 2]>,
    /// Of each point of a sweep, what it sets (`path=value`).
    pub(super) points: Vec<Vec<String>>,
}

/// A task of a job.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Task {
    pub(super) point: usize,
    /// Frame, where the job has frames.
    pub(super) frame: Option<u32>,
    pub(super) samples: Range<u64>,
}

impl Job {
    /// The version that is written.
    pub(super) const VERSION: u32 = VERSION;

    /// Reads a job.
    ///
    /// # Errors
    /// A file that is missing, too large, or no job.
    pub(super) fn read(path: &Path) -> Result<Self, Failure> {
        let name = path.display();
        let missing = |error: io::Error| {
            let what = match error.kind() {
                ErrorKind::NotFound => "there is no such file".to_owned(),
                kind => kind.to_string(),
            };
            let mend = "check the path, or make the job by snowgrain job plan";
            Failure::new(exit::INPUT_MISSING, format!("{name}: {what}; {mend}"))
        };
        let metadata = std::fs::metadata(path).map_err(missing)?;
        if !metadata.is_file() || metadata.len() > MOST_BYTES {
            return Err(Failure::bad_input(format!("{name}: this is not a job; name a job file")));
        }
        let text = std::fs::read(path).map_err(missing)?;
        let no_job = |what: String| {
            Failure::bad_input(format!("{name}: {what}; make it by snowgrain job plan"))
        };
        let job: Self = serde_json::from_slice(&text)
            .map_err(|error| no_job(format!("this is not a job ({error})")))?;
        let frames = job.frames.is_none_or(|[first, last]| first <= last);
        if job.version != VERSION || job.per_task == 0 || job.samples == 0 || !frames {
            return Err(no_job(format!("this is not a job of version {VERSION}")));
        }
        Ok(job)
    }

    /// Tasks of one picture.
    fn tasks_of_picture(&self) -> u64 {
        self.samples.div_ceil(self.per_task)
    }

    fn frame_count(&self) -> u64 {
        self.frames.map_or(1, |[first, last]| u64::from(last - first) + 1)
    }

    /// Number of tasks; `None` where it is beyond all numbers.
    pub(super) fn tasks(&self) -> Option<u64> {
        let pictures = (self.points.len() as u64).checked_mul(self.frame_count())?;
        pictures.checked_mul(self.tasks_of_picture())
    }

    /// A task by its number: samples first, then frames, then points.
    pub(super) fn task(&self, number: u64) -> Option<Task> {
        if number >= self.tasks()? {
            return None;
        }
        let (picture, part) = (number / self.tasks_of_picture(), number % self.tasks_of_picture());
        let start = part * self.per_task;
        let frame = (picture % self.frame_count()) as u32;
        Some(Task {
            point: (picture / self.frame_count()) as usize,
            frame: self.frames.map(|[first, _]| first + frame),
            samples: start..self.samples.min(start + self.per_task),
        })
    }

    /// First tasks of pictures in which every value of the sweep occurs, at the first frame.
    pub(super) fn tasks_of_every_value(&self) -> impl Iterator<Item = Task> + '_ {
        let mut seen = HashSet::new();
        let points = self.points.iter().enumerate().filter(move |(number, point)| {
            let new = point.iter().filter(|&set| seen.insert(set)).count();
            *number == 0 || new > 0
        });
        points.map(|(point, _)| Task {
            point,
            frame: self.frames.map(|[first, _]| first),
            samples: 0..self.samples.min(self.per_task),
        })
    }

    /// The folder of the films of a job in this file: `NAME-parts` beside it.
    pub(super) fn parts_folder(path: &Path) -> PathBuf {
        let name = path.file_stem().unwrap_or_default().to_string_lossy();
        path.with_file_name(format!("{name}-parts"))
    }

    /// The scene, as seen from where the program runs.
    pub(super) fn scene_path(&self, path: &Path) -> PathBuf {
        let is_file = Path::new(&self.scene).extension().is_some();
        match path.parent() {
            Some(folder) if is_file => folder.join(&self.scene),
            _ => PathBuf::from(&self.scene),
        }
    }
}

impl Task {
    /// Name of its film.
    pub(super) fn file_name(&self) -> String {
        let frame = self.frame.unwrap_or(0);
        format!("p{:05}-f{frame:05}-s{:010}.film", self.point, self.samples.start)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_sample_of_every_picture_is_in_one_task() {
        let job = Job {
            version: 1,
            scene: "a.toml".into(),
            options: Vec::new(),
            samples: 10,
            per_task: 4,
            frames: Some([3, 4]),
            points: vec![Vec::new(); 2],
        };
        assert_eq!(job.tasks(), Some(12));
        let tasks: Vec<_> = (0..12).map(|number| job.task(number).unwrap()).collect();
        assert_eq!(job.task(12), None);
        assert_eq!(tasks[4], Task { point: 0, frame: Some(4), samples: 4..8 });
        assert_eq!(tasks[11], Task { point: 1, frame: Some(4), samples: 8..10 });
        let mut names: Vec<_> = tasks.iter().map(Task::file_name).collect();
        names.dedup();
        assert_eq!(names.len(), 12);
        assert_eq!(job.tasks_of_every_value().count(), 1);
        let point = |sets: [&str; 2]| sets.map(str::to_owned).to_vec();
        let points = [["a=1", "b=1"], ["a=1", "b=2"], ["a=2", "b=1"], ["a=2", "b=2"]].map(point);
        let swept = Job { points: points.to_vec(), ..job };
        let tried: Vec<_> = swept.tasks_of_every_value().map(|task| task.point).collect();
        assert_eq!(tried, [0, 1, 2]);
        let path = Path::new("jobs/snow.json");
        assert_eq!(Job::parts_folder(path), Path::new("jobs/snow-parts"));
        assert_eq!(swept.scene_path(path), Path::new("jobs/a.toml"));
    }
}
