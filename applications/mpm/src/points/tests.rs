use super::fields::{append, names, total_energies};
use super::*;
use crate::points::conditions::PointConditions;
use crate::points::lost::Losses;
use bia_constitutive::{Kinematics, LameParameters, NeoHookean};
use bia_kernel::io::json::JsonObject;
use bia_kernel::model::{Model, ModelPart};
use bia_kernel::variables::Column;
use nalgebra::Matrix3;

/// Numbers without a pattern, in (−1, 1).
fn noise(seed: usize) -> f64 {
    (12.9898 * seed as f64).sin() * 43_758.545_3 % 1.0
}

fn column(width: usize, points: usize, seed: usize) -> Column {
    let mut column = Column::new(width, points);
    column.values_mut().iter_mut().enumerate().for_each(|(i, value)| *value = noise(seed + i));
    column
}

/// Points in space whose every column is used, with these ids.
fn block(body: usize, ids: Vec<u32>) -> Block {
    let (count, seed) = (ids.len(), 1000 * (body + 1));
    let mut gradient = column(9, count, seed);
    for point in 0..count {
        let f = Matrix3::identity() + 0.3 * expand(gradient.row(point));
        compress(&f, gradient.row_mut(point));
    }
    Block {
        body,
        material: 7,
        kinematics: Kinematics::ThreeDimensional,
        law_name: "law".into(),
        law: Box::new(NeoHookean::from_lame(LameParameters { lambda: 2.0, mu: 1.0 })),
        has_energy: true,
        moments: false,
        density: 3.0,
        extent: 1.0,
        starts_stressed: false,
        gravity: [0.1, -0.2, -9.81],
        body_acceleration: column(3, count, seed + 1),
        transfer: column(9, count, seed + 2),
        affine_energy: column(1, count, seed + 9),
        cell: ids.iter().map(|id| id % 5).collect(),
        ids,
        local: column(3, count, seed + 2),
        position: column(3, count, seed + 3),
        displacement: column(3, count, seed + 4),
        velocity: column(3, count, seed + 5),
        acceleration: column(3, count, seed + 6),
        mass: column(1, count, seed + 7),
        gradient,
        state: column(2, count, seed + 8),
        stress: column(6, count, seed + 9),
        strain: column(6, count, seed + 10),
        volume: column(1, count, seed + 11),
        pressure: column(1, count, seed + 12),
    }
}

fn points(blocks: Vec<Block>) -> MaterialPoints {
    MaterialPoints {
        name: "MPM_Material".into(),
        kinematics: Kinematics::ThreeDimensional,
        dynamic: true,
        bodies: vec!["A".into(), "B".into()],
        blocks,
        conditions: PointConditions::default(),
        losses: Losses::default(),
    }
}

/// Two bodies whose ids alternate in places, and have gaps.
fn two_bodies() -> MaterialPoints {
    let first = (10..70).chain(90..101).collect();
    let second = (70..90).chain(105..140).chain([100_000]).collect();
    points(vec![block(0, first), block(1, second)])
}

/// An order without a pattern.
fn shuffled(count: usize) -> Vec<u32> {
    let mut order: Vec<u32> = (0..count as u32).collect();
    order.sort_by(|a, b| noise(77 + *a as usize).total_cmp(&noise(77 + *b as usize)));
    order
}

/// All that the record, the saved state and the energies say, and each variable of each point.
fn outputs(points: MaterialPoints) -> (Vec<u8>, Vec<u8>, [f64; 3], Vec<f64>) {
    let energies = total_energies(&points, Selection::All);
    let mut values = Vec::new();
    for (b, p) in points.by_id(Selection::All) {
        assert!(names().all(|name| append(&points.blocks[b as usize], p as usize, name, &mut values)));
    }
    let mut model = Model::default();
    model.insert(ModelPart::new(crate::grid::GRID));
    model.extend(points);
    let mut record = Vec::new();
    let mut object = JsonObject::open(&mut record).unwrap();
    crate::record::snapshot(&model, &mut object).unwrap();
    let folder = tempfile::tempdir().unwrap();
    let files = crate::inventory::save_state(&model, folder.path()).unwrap();
    let state = std::fs::read(&files[0]).unwrap();
    (record, state, [energies.potential, energies.kinetic, energies.strain], values)
}

#[test]
fn outputs_do_not_depend_on_the_order_of_points() {
    let expected = outputs(two_bodies());
    assert!(expected.3.iter().all(|value| value.is_finite()));
    let mut mixed = two_bodies();
    let mut scratch = Scratch::default();
    for block in &mut mixed.blocks {
        let order = shuffled(block.len());
        block.reorder(&order, &mut scratch);
        assert!(!block.ids.is_sorted());
    }
    assert!(outputs(mixed) == expected);
    assert!(outputs(points(two_bodies().blocks.into_iter().rev().collect())).3 == expected.3);
}

/// All columns, ids and cells move together, and the points that stay keep their order.
#[test]
fn points_keep_what_is_theirs() {
    let (before, order) = (block(0, (10..110).collect()), shuffled(100));
    let mut after = block(0, (10..110).collect());
    after.reorder(&order, &mut Scratch::default());
    let same = |a: &Block, p: usize, b: &Block, q: usize| {
        let columns = a.columns().into_iter().zip(b.columns());
        (a.ids[p], a.cell[p]) == (b.ids[q], b.cell[q])
            && columns.into_iter().all(|((_, a), (_, b))| a.is_used() && a.row(p) == b.row(q))
    };
    assert!((0..100).all(|k| same(&after, k, &before, order[k] as usize)));
    let keep: Vec<bool> = (0..100).map(|k| noise(k) > 0.0).collect();
    after.retain(&keep);
    let kept: Vec<usize> = (0..100).filter(|&k| keep[k]).collect();
    assert!((20..80).contains(&kept.len()) && after.len() == kept.len());
    assert!(kept.iter().enumerate().all(|(k, &old)| same(&after, k, &before, order[old] as usize)));
}

#[test]
fn points_are_listed_by_id() {
    let mut mixed = two_bodies();
    for block in &mut mixed.blocks {
        let order = shuffled(block.len());
        block.reorder(&order, &mut Scratch::default());
    }
    for selection in [Selection::All, Selection::Body(0), Selection::Body(1)] {
        let ids: Vec<u32> =
            mixed.by_id(selection).iter().map(|&(b, p)| mixed.blocks[b as usize].ids[p as usize]).collect();
        let held = mixed.blocks.iter().filter(|block| selection.holds(block.body));
        assert_eq!(ids.len(), held.map(Block::len).sum::<usize>());
        assert!(ids.windows(2).all(|pair| pair[0] < pair[1]));
    }
}
