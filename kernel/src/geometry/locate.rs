//! The search for the cell that holds a point.

use super::bins::Bins;
use super::regular::RegularGrid;
use super::search_mesh::SearchMesh;
use crate::model::ModelPart;

/// Halvings of the way out of the mesh: the place is found to about its share 1e-12.
const HALVINGS: usize = 40;

/// Finds the element that holds a point, by the rules of Kratos's search: first the hinted
/// element, then those that share a node with it, then all, each in ascending order; a point on a
/// face, or outside by less than the tolerance, stays where it was.
///
/// In a mesh of solids the elements of fewer dimensions hold no points. Triangles and
/// quadrilaterals are searched in the plane of the first two coordinates, lines along the first.
#[derive(Debug, Clone)]
pub struct CellLocator {
    mesh: SearchMesh,
    search: Search,
    /// Lowest and highest coordinates of the mesh.
    bounds: [[f64; 3]; 2],
}

#[derive(Debug, Clone)]
enum Search {
    Regular(RegularGrid),
    General {
        /// Where each node's list of cells starts, one more entry than nodes.
        starts: Vec<u32>,
        /// The cells of each node, ascending.
        cells: Vec<u32>,
        bins: Bins,
    },
}

impl CellLocator {
    /// Prepares the search among the elements of `part`; `tolerance` (not negative) is in local
    /// coordinates, as in [`Shape::contains`](super::Shape::contains).
    pub fn new(part: &ModelPart, tolerance: f64) -> Self {
        let mesh = SearchMesh::new(part, &part.elements, tolerance);
        match RegularGrid::of(&mesh) {
            Ok(regular) => Self { bounds: mesh.all_bounds(), mesh, search: Search::Regular(regular) },
            Err(_) => Self::general(part, mesh),
        }
    }

    fn general(part: &ModelPart, mesh: SearchMesh) -> Self {
        let (starts, cells) = part.cells_of_nodes(&part.elements);
        let bins = Bins::new(&mesh);
        Self { bounds: mesh.all_bounds(), mesh, search: Search::General { starts, cells, bins } }
    }

    /// Index of the element that holds `x` and the local coordinates there; `hint` is the element
    /// of the step before. None if no element holds `x` within the tolerance.
    #[inline]
    pub fn locate(&self, x: [f64; 3], hint: Option<u32>) -> Option<(u32, [f64; 3])> {
        let hint = hint.filter(|&cell| (cell as usize) < self.mesh.len());
        if let Some(cell) = hint
            && let Some(xi) = self.mesh.local_coordinates(cell as usize, x)
        {
            return Some((cell, xi));
        }
        self.search(x, hint)
    }

    /// As [`CellLocator::locate`], but a point that lies outside the hinted element by less than the
    /// tolerance changes to one that holds it without, if there is one. The functions of a cell are
    /// not negative at its points then.
    #[inline]
    pub fn locate_inside(&self, x: [f64; 3], hint: Option<u32>) -> Option<(u32, [f64; 3])> {
        let found = self.locate(x, hint)?;
        if self.mesh.holds(found.0 as usize, found.1) { Some(found) } else { self.inside(x).or(Some(found)) }
    }

    /// A place in the mesh for a point that lies outside of it and was in the element `last`: the nearest
    /// one in the box around the mesh, or, if the mesh does not fill its box there, where the way from the
    /// middle of that element leaves the mesh. With it, the element and the local coordinates there. None
    /// for coordinates that are not finite.
    pub fn clamp(&self, x: [f64; 3], last: u32) -> Option<([f64; 3], u32, [f64; 3])> {
        let [low, high] = self.bounds;
        let mut boxed = x;
        for i in 0..self.mesh.dimension {
            boxed[i] = x[i].max(low[i]).min(high[i]);
        }
        if !x.iter().all(|x| x.is_finite()) || last as usize >= self.mesh.len() {
            return None;
        }
        let place = |x: [f64; 3]| self.locate_inside(x, Some(last)).map(|(cell, xi)| (x, cell, xi));
        if let Some(found) = place(boxed) {
            return Some(found);
        }
        let nodes = self.mesh.nodes_of(last as usize);
        let middle: [f64; 3] = std::array::from_fn(|i| {
            nodes.iter().map(|&node| self.mesh.coordinates(node)[i]).sum::<f64>() / nodes.len() as f64
        });
        // Inside at 0, outside at 1.
        let (mut inside, mut outside) = (0.0, 1.0);
        let on_the_way = |share: f64| std::array::from_fn(|i| middle[i] + share * (boxed[i] - middle[i]));
        for _ in 0..HALVINGS {
            let share = 0.5 * (inside + outside);
            match place(on_the_way(share)) {
                Some(_) => inside = share,
                None => outside = share,
            }
        }
        place(on_the_way(inside))
    }

    /// The first element that holds a point without any tolerance.
    fn inside(&self, x: [f64; 3]) -> Option<(u32, [f64; 3])> {
        let first = |candidates: &[u32]| {
            let of = |&cell: &u32| Some((cell, self.mesh.local_coordinates(cell as usize, x)?));
            candidates.iter().filter_map(of).find(|found| self.mesh.holds(found.0 as usize, found.1))
        };
        match &self.search {
            Search::Regular(regular) => first(regular.candidates(x).as_slice()),
            Search::General { bins, .. } => first(bins.candidates(x)),
        }
    }

    /// True if the elements were recognised as a regular grid.
    pub fn is_regular(&self) -> bool {
        matches!(self.search, Search::Regular(_))
    }

    /// One line on how the search works here, for the log.
    pub fn describe(&self) -> String {
        match &self.search {
            Search::Regular(regular) => regular.describe(),
            Search::General { bins, .. } => {
                let (counts, average) = bins.statistics();
                let counts = counts[..self.mesh.dimension.max(1)].iter().map(usize::to_string);
                let counts = counts.collect::<Vec<_>>().join(" x ");
                format!("{} cells in {counts} bins, {average:.1} cells in a bin on average", self.mesh.len())
            }
        }
    }

    #[inline(never)]
    fn search(&self, x: [f64; 3], hint: Option<u32>) -> Option<(u32, [f64; 3])> {
        match &self.search {
            Search::Regular(regular) => self.among(regular.candidates(x).as_slice(), x, hint),
            Search::General { starts, cells, bins } => {
                let candidates = bins.candidates(x);
                // The bin answers alone; where a graded mesh crowds it, the neighbours are fewer.
                if let Some(hint) = hint {
                    let around =
                        |&node: &u32| &cells[starts[node as usize] as usize..starts[node as usize + 1] as usize];
                    let lists = || self.mesh.nodes_of(hint as usize).iter().map(around);
                    if lists().map(<[u32]>::len).sum::<usize>() < candidates.len()
                        && let Some(found) = self.lowest(lists(), x)
                    {
                        return Some(found);
                    }
                }
                self.among(candidates, x, hint)
            }
        }
    }

    /// The first of the ascending `candidates` that holds `x` and touches the hint, or else the
    /// first that holds `x`.
    #[inline]
    fn among(&self, candidates: &[u32], x: [f64; 3], hint: Option<u32>) -> Option<(u32, [f64; 3])> {
        let mut lowest = None;
        for &cell in candidates {
            let Some(xi) = self.mesh.local_coordinates(cell as usize, x) else { continue };
            if hint.is_none_or(|hint| self.mesh.share_node(hint as usize, cell as usize)) {
                return Some((cell, xi));
            }
            lowest = lowest.or(Some((cell, xi)));
        }
        lowest
    }

    /// The lowest cell of several ascending lists that holds `x`.
    fn lowest<'a>(&self, lists: impl Iterator<Item = &'a [u32]>, x: [f64; 3]) -> Option<(u32, [f64; 3])> {
        let mut lowest = None;
        let mut below = u32::MAX;
        for list in lists {
            for &cell in list {
                if cell >= below {
                    break;
                }
                if let Some(xi) = self.mesh.local_coordinates(cell as usize, x) {
                    (lowest, below) = (Some((cell, xi)), cell);
                }
            }
        }
        lowest
    }
}

#[cfg(test)]
mod tests;
