//! x
use snowgrain_geometry::Quantisation;
use snowgrain_grains::*;
use snowgrain_math::DVec3;
use std::time::Instant;
fn main() -> Result<(), Box<dyn std::error::Error>> {
    for density in std::env::args().skip(1) {
        let density: f64 = density.parse()?;
        let r = 0.5e-3;
        let q = Quantisation::for_grains(DVec3::ZERO, r);
        let start = Instant::now();
        let pack = PackSettings { radii: Radii::equal(r), density, seed: 0 }.make(q.quantum());
        match pack {
            Ok(p) => {
                let s = start.elapsed().as_secs_f64();
                let c = measures::connections_of_pack(&p);
                println!(
                    "{density}: {:.1} n {} period {:.1} {s:.2}s {} contacts {:.2} conn {:.4} overlap {:.2e}",
                    p.solid_fraction * 917.,
                    p.field.len(),
                    p.period[0] as f64 / 5450.,
                    p.method,
                    c.contacts_per_grain,
                    c.connected_fraction,
                    c.greatest_overlap_depth / r
                );
            }
            Err(e) => println!("{e} {:.2}", start.elapsed().as_secs_f64()),
        }
    }
    Ok(())
}
