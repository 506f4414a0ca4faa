//! What the shadow catchers of a scene would show if there were nothing else: the scene of them and of
//! the lights alone.

use crate::description::{DirectView, LightKind, SceneDescription};
use crate::strata::Strata;

/// The scene of the shadow catchers and the lights alone, `None` where there are no shadow catchers. The slots
/// of its lights are those of the whole scene.
pub(crate) fn alone(scene: &SceneDescription) -> Option<SceneDescription> {
    let is_catcher = |direct_view| direct_view == DirectView::ShadowCatcher;
    if !scene.objects.iter().any(|object| is_catcher(object.direct_view)) {
        return None;
    }
    let mut alone = scene.clone();
    let shines = |at: usize| {
        let is_it =
            |kind: &LightKind| matches!(kind, LightKind::Object { object } if *object == at);
        scene.lights.iter().any(|light| is_it(&light.kind))
    };
    // Where each object stands among those that are left.
    let mut places = Vec::new();
    alone.objects.clear();
    for (at, object) in scene.objects.iter().enumerate() {
        places.push(alone.objects.len());
        if is_catcher(object.direct_view) || shines(at) {
            alone.objects.push(object.clone());
        }
    }
    for object in &mut alone.objects {
        object.direct_view = DirectView::Seen;
    }
    for light in &mut alone.lights {
        if let LightKind::Object { object } = &mut light.kind {
            *object = places[*object];
        }
    }
    alone.snow.clear();
    alone.strata = Strata::default();
    alone.film.keep_ice_paths = false;
    alone.film.keep_light_groups = false;
    Some(alone)
}
