//! Model parts: a root owns nodes, elements and conditions; sub model parts list indices of them.

use super::{Properties, Table};
use crate::geometry::Shape;
use crate::variables::Fields;
use std::collections::{BTreeMap, HashMap};

/// Nodes of a root model part, ascending by id.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Nodes {
    /// Ids of the input file.
    pub ids: Vec<u32>,
    /// Coordinates in metres; the third is 0 in the plane.
    pub coordinates: Vec<[f64; 3]>,
}

impl Nodes {
    /// Number of nodes.
    pub fn len(&self) -> usize {
        self.ids.len()
    }

    /// True without nodes.
    pub fn is_empty(&self) -> bool {
        self.ids.is_empty()
    }

    /// Index of the node with this id.
    pub fn index(&self, id: u32) -> Option<u32> {
        find(&self.ids, id)
    }

    /// First `D` coordinates of a cell's nodes.
    #[inline]
    pub fn gather<const D: usize, const N: usize>(&self, nodes: &[u32]) -> [[f64; D]; N] {
        std::array::from_fn(|i| {
            let x = &self.coordinates[nodes[i] as usize];
            std::array::from_fn(|a| x[a])
        })
    }
}

/// Index of `id` in ascending `ids`; ids without gaps are found without a search.
fn find(ids: &[u32], id: u32) -> Option<u32> {
    let first = *ids.first()?;
    let guess = id.checked_sub(first)? as usize;
    if ids.get(guess) == Some(&id) {
        return Some(guess as u32);
    }
    ids.binary_search(&id).ok().map(|i| i as u32)
}

/// Elements, conditions or geometries of a root model part, ascending by id.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Cells {
    /// Ids of the input file.
    pub ids: Vec<u32>,
    /// Shape of each cell.
    pub shapes: Vec<Shape>,
    /// Registered name of each cell, as an index into `names`.
    pub kinds: Vec<u16>,
    /// The names that occur, such as `Element2D4N`.
    pub names: Vec<String>,
    /// Id of the properties of each cell (0 where a geometry has none).
    pub properties: Vec<u32>,
    /// Start of each cell's node list in `nodes`; one more entry than cells.
    pub starts: Vec<u32>,
    /// Node indices of all cells, one after the other.
    pub nodes: Vec<u32>,
}

impl Cells {
    /// Number of cells.
    pub fn len(&self) -> usize {
        self.ids.len()
    }

    /// True without cells.
    pub fn is_empty(&self) -> bool {
        self.ids.is_empty()
    }

    /// Index of the cell with this id.
    pub fn index(&self, id: u32) -> Option<u32> {
        find(&self.ids, id)
    }

    /// Node indices of a cell.
    pub fn nodes_of(&self, cell: usize) -> &[u32] {
        &self.nodes[self.starts[cell] as usize..self.starts[cell + 1] as usize]
    }

    /// Registered name of a cell.
    pub fn name_of(&self, cell: usize) -> &str {
        &self.names[self.kinds[cell] as usize]
    }

    /// Appends a cell. Callers append ascending ids, or call [`Cells::sort_by_id`] at the end.
    pub fn push(&mut self, id: u32, name: &str, shape: Shape, properties: u32, nodes: &[u32]) {
        let kind = self.names.iter().rposition(|n| n == name).unwrap_or_else(|| {
            self.names.push(name.to_string());
            self.names.len() - 1
        });
        if self.starts.is_empty() {
            self.starts.push(0);
        }
        self.ids.push(id);
        self.shapes.push(shape);
        self.kinds.push(kind as u16);
        self.properties.push(properties);
        self.nodes.extend_from_slice(nodes);
        self.starts.push(self.nodes.len() as u32);
    }

    /// Brings the cells into ascending order of id, which fixes every later order of iteration.
    pub fn sort_by_id(&mut self) {
        if self.ids.is_sorted() {
            return;
        }
        let mut order: Vec<usize> = (0..self.len()).collect();
        order.sort_by_key(|&i| self.ids[i]);
        let mut sorted = Cells { names: self.names.clone(), ..Cells::default() };
        for i in order {
            sorted.push(
                self.ids[i],
                &self.names[self.kinds[i] as usize],
                self.shapes[i],
                self.properties[i],
                self.nodes_of(i),
            );
        }
        *self = sorted;
    }
}

/// A named subset of a root model part: indices into the root's containers, ascending.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct SubModelPart {
    /// Name without the parents' names.
    pub name: String,
    /// Indices of nodes.
    pub nodes: Vec<u32>,
    /// Indices of elements.
    pub elements: Vec<u32>,
    /// Indices of conditions.
    pub conditions: Vec<u32>,
    /// Indices of geometries.
    pub geometries: Vec<u32>,
    /// Ids of tables.
    pub tables: Vec<u32>,
    /// Ids of properties.
    pub properties: Vec<u32>,
    /// Parts of this part, in the order of the file; what a child holds its parents hold too.
    pub children: Vec<SubModelPart>,
}

/// A root model part with its tree of sub model parts.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct ModelPart {
    /// Name, such as `Background_Grid`.
    pub name: String,
    /// Nodes.
    pub nodes: Nodes,
    /// Elements.
    pub elements: Cells,
    /// Conditions.
    pub conditions: Cells,
    /// Geometries without physics, from which modelers make elements and conditions.
    pub geometries: Cells,
    /// Properties by id.
    pub properties: BTreeMap<u32, Properties>,
    /// Tables by id.
    pub tables: BTreeMap<u32, Table>,
    /// Sub model parts of the first level, in the order of the file.
    pub children: Vec<SubModelPart>,
    /// Values on the nodes, allocated on demand.
    pub node_fields: Fields,
    /// Values on the elements, allocated on demand.
    pub element_fields: Fields,
    /// Values on the conditions, allocated on demand.
    pub condition_fields: Fields,
    /// Data given to nodes in the mesh file: variable → (node index, fixed, value).
    pub nodal_data: BTreeMap<String, Vec<(u32, bool, super::Value)>>,
    /// Data given to elements in the mesh file: variable → (element index, value).
    pub elemental_data: BTreeMap<String, Vec<(u32, super::Value)>>,
    /// Data given to conditions in the mesh file: variable → (condition index, value).
    pub conditional_data: BTreeMap<String, Vec<(u32, super::Value)>>,
}

impl ModelPart {
    /// An empty root part.
    pub fn new(name: &str) -> Self {
        Self { name: name.into(), ..Self::default() }
    }

    /// The sub model part at a dotted path below this root (`Parent.Child`).
    pub fn find(&self, path: &str) -> Option<&SubModelPart> {
        let mut names = path.split('.');
        let first = names.next()?;
        let mut part = self.children.iter().find(|child| child.name == first)?;
        for name in names {
            part = part.children.iter().find(|child| child.name == name)?;
        }
        Some(part)
    }

    /// Dotted paths of all sub model parts, depth first.
    pub fn paths(&self) -> Vec<String> {
        fn walk(parts: &[SubModelPart], prefix: &str, out: &mut Vec<String>) {
            for part in parts {
                let path = if prefix.is_empty() { part.name.clone() } else { format!("{prefix}.{}", part.name) };
                out.push(path.clone());
                walk(&part.children, &path, out);
            }
        }
        let mut out = Vec::new();
        walk(&self.children, "", &mut out);
        out
    }

    /// Coordinates of a cell's nodes.
    pub fn corners(&self, cells: &Cells, cell: usize) -> Vec<[f64; 3]> {
        cells.nodes_of(cell).iter().map(|&n| self.nodes.coordinates[n as usize]).collect()
    }

    /// Normals on the nodes of these conditions, ascending by node: the sum of the conditions' normals,
    /// each as long as the node's share of the condition's length (m) or area (m²).
    pub fn nodal_normals(&self, conditions: &[u32]) -> Vec<(u32, [f64; 3])> {
        let mut sums: BTreeMap<u32, [f64; 3]> = BTreeMap::new();
        for &condition in conditions {
            let (shape, nodes) =
                (self.conditions.shapes[condition as usize], self.conditions.nodes_of(condition as usize));
            let corners = self.corners(&self.conditions, condition as usize);
            let normal = shape.normal(&corners, shape.center());
            let share = shape.reference_measure() / nodes.len() as f64;
            for &node in nodes {
                let sum = sums.entry(node).or_default();
                (0..3).for_each(|a| sum[a] += share * normal[a]);
            }
        }
        sums.into_iter().collect()
    }

    /// For each node the cells of `cells` that hold it, ascending: (starts, cell indices).
    pub fn cells_of_nodes(&self, cells: &Cells) -> (Vec<u32>, Vec<u32>) {
        let mut starts = vec![0u32; self.nodes.len() + 1];
        for &node in &cells.nodes {
            starts[node as usize + 1] += 1;
        }
        for i in 1..starts.len() {
            starts[i] += starts[i - 1];
        }
        let (mut next, mut list) = (starts.clone(), vec![0u32; cells.nodes.len()]);
        for cell in 0..cells.len() {
            for &node in cells.nodes_of(cell) {
                list[next[node as usize] as usize] = cell as u32;
                next[node as usize] += 1;
            }
        }
        (starts, list)
    }

    /// Map from id to index of any id list, for readers that meet ids in any order.
    pub fn index_map(ids: &[u32]) -> HashMap<u32, u32> {
        ids.iter().enumerate().map(|(i, &id)| (id, i as u32)).collect()
    }
}
