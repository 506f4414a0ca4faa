//! Films of parts of a picture put together.

use crate::{Film, FilmError, PixelRect};

impl Film {
    /// One film of films of the same picture and the same samples whose crops lie side by side and fill a
    /// rectangle. Its bytes are those of a film that was rendered whole.
    ///
    /// # Errors
    /// No film; films of different pictures or samples; films whose blocks have counts of samples of
    /// their own; crops that overlap or leave gaps; more than memory.
    pub fn assembled(parts: &[Self]) -> Result<Self, FilmError> {
        let Some(first) = parts.first() else { return Err(FilmError::NoFilms) };
        let mut whole = first.crop();
        for part in parts {
            first.check_same_but_crop(part)?;
            if part.block_counts().is_some() {
                return Err(FilmError::CropsWithCounts);
            }
            if part.samples() != first.samples() {
                let samples = |film: &Self| film.samples().to_string();
                let (ours, theirs) = (samples(first), samples(part));
                return Err(FilmError::FilmsDiffer { what: "samples", ours, theirs });
            }
            let crop = part.crop();
            whole = PixelRect::new(
                whole.x0.min(crop.x0),
                whole.y0.min(crop.y0),
                whole.x1.max(crop.x1),
                whole.y1.max(crop.y1),
            );
        }
        for (index, part) in parts.iter().enumerate() {
            let overlaps = |other: &&Self| !other.crop().intersection(&part.crop()).is_empty();
            if let Some(other) = parts[..index].iter().find(overlaps) {
                return Err(FilmError::CropsOverlap { ours: other.crop(), theirs: part.crop() });
            }
        }
        let area: u64 = parts.iter().map(|part| part.crop().area()).sum();
        if area != whole.area() {
            return Err(FilmError::CropsLeaveGaps { whole, pixels: whole.area() - area });
        }
        let mut film = first.empty_copy_of(whole)?;
        for part in parts {
            film.place(part)?;
        }
        Ok(film)
    }
}
