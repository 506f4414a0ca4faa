//! Names of the channels of spectral layers and of layers of light.

use snowgrain_film::LightLayer;
use snowgrain_film::light_layers::GLINTS;

/// Components of a colour, as channels are named.
pub(super) const COMPONENTS: [&str; 3] = ["R", "G", "B"];

/// The channel of a wavelength: the whole and the broken part of nanometres with a comma between.
pub(super) fn spectral_name(wavelength_nm: f64) -> String {
    format!("S0.{}nm", format!("{wavelength_nm:?}").replace('.', ","))
}

/// The wavelength of such a channel, nm.
pub(super) fn spectral_wavelength(name: &str) -> Option<f64> {
    let digits = name.strip_prefix("S0.")?.strip_suffix("nm")?;
    let plain = !digits.is_empty() && digits.chars().all(|c| c.is_ascii_digit() || c == ',');
    plain.then(|| digits.replace(',', ".").parse().ok()).flatten()
}

/// What the channels of a layer of light begin with.
pub(super) fn light_prefix(name: &str) -> String {
    match name {
        GLINTS => "Glints".into(),
        name => format!("Groups.{name}"),
    }
}

/// The layer and component of such a channel.
pub(super) fn light_channel(name: &str) -> Option<(&str, usize)> {
    let (prefix, component) = name.rsplit_once('.')?;
    let component = COMPONENTS.iter().position(|&known| known == component)?;
    let layer = match prefix {
        "Glints" => GLINTS,
        prefix => prefix.strip_prefix("Groups.").filter(|&name| name != GLINTS)?,
    };
    Some((layer, component))
}

/// Layers of light of which all components are there: groups in the order of the file, then glints.
pub(super) fn light_layers(channels: Vec<(String, usize, Vec<f32>)>) -> Vec<LightLayer> {
    let mut layers: Vec<LightLayer> = Vec::new();
    for (name, component, values) in channels {
        let at = layers.iter().position(|layer| layer.name == name).unwrap_or_else(|| {
            layers.push(LightLayer { name, values: [const { Vec::new() }; 3] });
            layers.len() - 1
        });
        layers[at].values[component] = values;
    }
    layers.retain(|layer| layer.values.iter().all(|values| !values.is_empty()));
    layers.sort_by_key(|layer| layer.name == GLINTS);
    layers
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn spectral_channels_are_named_by_their_wavelength() {
        assert_eq!(spectral_name(550.0), "S0.550,0nm");
        assert_eq!(spectral_name(412.25), "S0.412,25nm");
        assert_eq!(spectral_wavelength("S0.412,25nm"), Some(412.25));
        for other in ["S0.nm", "S1.550,0nm", "S0.-5nm", "R", "S0.5,5,5nm"] {
            assert_eq!(spectral_wavelength(other), None, "{other}");
        }
    }

    #[test]
    fn layers_of_light_have_channels_of_their_own() {
        assert_eq!(light_channel("Groups.sun.G"), Some(("sun", 1)));
        assert_eq!(light_channel("Glints.B"), Some((GLINTS, 2)));
        for other in ["Groups.sun", "Groups.sun.A", "Albedo.R", "Groups.glints.R", "R"] {
            assert_eq!(light_channel(other), None, "{other}");
        }
        // A layer of which a component is missing is left out.
        let channel = |component| ("sun".to_owned(), component, vec![1.0]);
        assert_eq!(light_layers(vec![channel(0), channel(2)]), []);
        assert_eq!(light_layers((0..3).map(channel).collect()).len(), 1);
    }
}
