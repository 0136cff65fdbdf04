//! Orthogonal choices of a discretisation: frame, functions, placement of points, transfer.

use bia_kernel::diagnostic::InputErrors;
use bia_kernel::parameters::Settings;

/// Where the grid's functions are evaluated.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Frame {
    /// At the present position of each point; the grid is reset after each step.
    #[default]
    Updated,
    /// At the first position of each point, for ever (de Vaucorbeil, Nguyen & Hutchinson 2020): no
    /// point crosses a cell, and none is searched for.
    Total,
}

/// Functions of the grid.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Basis {
    /// Those of the mesh's own cells.
    #[default]
    Mesh,
    /// Lagrange polynomials of this degree with evenly spaced nodes in each cell of a regular grid.
    Lagrange(usize),
    /// B-splines of this degree on a regular grid, open at its ends.
    BSpline(usize),
}

/// Where a body's cells hold their points.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Placement {
    /// At Gauss points, with their weights.
    #[default]
    Gauss,
    /// At the centres of equal parts of the cell.
    Even,
}

/// The choices that implicit and explicit solvers share.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Discretisation {
    /// Frame.
    pub frame: Frame,
    /// Functions.
    pub basis: Basis,
    /// Placement of points.
    pub placement: Placement,
}

impl Discretisation {
    /// As the settings say.
    pub fn of(s: &Settings) -> Self {
        let order = s.integer("basis_order") as usize;
        Self {
            frame: if s.text("frame") == "total_lagrangian" || never_reset(s) { Frame::Total } else { Frame::Updated },
            basis: match s.text("basis") {
                "lagrange" => Basis::Lagrange(order),
                "b_spline" => Basis::BSpline(order),
                _ => Basis::Mesh,
            },
            placement: if s.text("point_placement") == "even" { Placement::Even } else { Placement::Gauss },
        }
    }
}

/// How velocity returns to the points.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Transfer {
    /// v ← α (v + Σ N Δv) + (1 − α) Σ N v: FLIP for α = 1, PIC for α = 0 (Brackbill & Ruppel 1986).
    Flip(f64),
    /// PIC with an affine field about each point (Jiang et al. 2015).
    Apic,
    /// PIC with the gradient of the grid's velocity at each point (Nakamura et al. 2023).
    Tpic,
    /// FLIP without the null space of the transfer, by so many projections (Hammerquist & Nairn 2017).
    Xpic(usize),
}

impl Transfer {
    /// As the settings say.
    pub fn of(s: &Settings) -> Self {
        match s.text("transfer") {
            "pic" => Transfer::Flip(0.0),
            "apic" => Transfer::Apic,
            "tpic" => Transfer::Tpic,
            "xpic" => Transfer::Xpic(s.integer("xpic_order") as usize),
            _ => Transfer::Flip(s.number("flip_fraction")),
        }
    }
}

/// The grid is never reset.
fn never_reset(s: &Settings) -> bool {
    s.given("grid_reset") && s.text("grid_reset") == "never"
}

/// `frame` and `grid_reset` say the same thing.
pub fn check_frame(s: &Settings, errors: &mut InputErrors) {
    if s.given("frame") && s.given("grid_reset") && (s.text("frame") == "total_lagrangian") != never_reset(s) {
        let message = format!("{:?} contradicts frame {:?}", s.text("grid_reset"), s.text("frame"));
        errors.push(s.error("grid_reset", message).help("keep one of them: \"never\" is the total Lagrangian frame"));
    }
}
