//! Keys of `solver_settings`, with Kratos's names and defaults where Kratos has them.

use super::mixed::PARAMETERS;
use bia_constitutive::MATERIAL_IMPORT;
use bia_kernel::parameters::{Key, Kind, Range};
use bia_kernel::solving::mesh::MESH_IMPORT;
use bia_kernel::solving::newton::CONVERGENCE;
use bia_kernel::solving::stepping::TIME_STEPPING;

const SEARCH: &[Key] = &[
    Key::new("search_algorithm_type", Kind::Choice(&["bin_based"]), "\"bin_based\"", "accepted; Bia chooses"),
    Key::new("max_number_of_results", Kind::Integer { min: 1 }, "1000", "accepted"),
    Key::new("searching_tolerance", Kind::Number(Range::NOT_NEGATIVE), "1e-5", "tolerance in local coordinates"),
    Key::new("remove_entities_not_found", Kind::Bool, "true", "erase points that leave the grid"),
];

/// Keys of `solver_settings`.
pub const KEYS: &[Key] = &Key::join::<8, 47, 55>(
    CONVERGENCE,
    [
        Key::required("solver_type", Kind::Text, "static, quasi_static or dynamic"),
        Key::new("model_part_name", Kind::Text, "\"MPM_Material\"", "name of the part of material points"),
        Key::required("domain_size", Kind::Integer { min: 1 }, "dimension of space: 1, 2 or 3"),
        Key::new("echo_level", Kind::Integer { min: 0 }, "0", "ignored: --quiet and the log level rule"),
        Key::new(
            "time_integration_method",
            Kind::Choice(&["implicit", "explicit"]),
            "\"implicit\"",
            "dynamic: implicit or explicit",
        ),
        Key::optional(
            "scheme_type",
            Kind::Choice(&[
                "newmark",
                "bossak",
                "quasi_static",
                "energy_conserving",
                "forward_euler",
                "central_difference",
                "velocity_verlet",
                "yoshida",
            ]),
            "dynamic: time scheme, by default bossak if implicit and central_difference if explicit; \
             energy_conserving: mid-point rule with consistent mass in the total Lagrangian frame; velocity_verlet \
             and yoshida (fourth order): explicit and symplectic, in the total Lagrangian frame",
        ),
        Key::new(
            "stress_update",
            Kind::Choice(&["usf", "usl", "musl"]),
            "\"usf\"",
            "forward_euler: update stress first, last, or last with velocities of the moved points",
        ),
        Key::new(
            "is_fix_explicit_mp_on_grid_edge",
            Kind::Bool,
            "false",
            "explicit: move points off the edges of cells",
        ),
        Key::new("is_pqmpm", Kind::Bool, "false", "explicit: partitioned quadrature"),
        Key::new("is_make_normal_mp_if_pqmpm_fails", Kind::Bool, "false", "of the partitioned quadrature"),
        Key::new(
            "pqmpm_subpoint_min_volume_fraction",
            Kind::Number(Range::FRACTION),
            "0.0",
            "of the partitioned quadrature",
        ),
        Key::new("damp_factor_m", Kind::Number(Range::NOT_POSITIVE), "-0.3", "Bossak's alpha").adjustable(),
        Key::new("newmark_beta", Kind::Number(Range::POSITIVE), "0.25", "Newmark's beta for alpha = 0"),
        Key::new(
            "point_velocity_rule",
            Kind::Choice(&["trapezoidal", "scheme"]),
            "\"trapezoidal\"",
            "weight of the new acceleration in a point's velocity: 1/2 as in Kratos, or the scheme's gamma",
        ),
        Key::new(
            "held_motion",
            Kind::Choice(&["gathered", "imposed"]),
            "\"gathered\"",
            "with which velocity held nodes start an implicit step: of the points beside, as in Kratos, or of their \
             support, which is of higher order; in the total frame always the latter",
        ),
        Key::required("time_stepping", Kind::Object(TIME_STEPPING), "the time step [s]").adjustable(),
        Key::new("compute_reactions", Kind::Bool, "false", "compute REACTION on fixed nodes"),
        Key::new("pressure_dofs", Kind::Bool, "false", "mixed displacement-pressure formulation"),
        Key::new(
            "stabilization",
            Kind::Choice(&["ppp", "none", "asgs", "osgs"]),
            "\"ppp\"",
            "of the mixed formulation",
        ),
        Key::optional(
            "stabilization_variant",
            Kind::Choice(&["kratos", "consistent"]),
            "formulas of the stabilisation and of the convergence criterion: Kratos's, or consistent ones with the \
             exact tangent (default, unless Kratos is repeated)",
        ),
        Key::new(
            "stabilization_parameters",
            Kind::Object(PARAMETERS),
            "{}",
            "constants of the stabilisation of the mixed formulation",
        ),
        Key::new(
            "volumetric_law",
            Kind::Choice(&["kratos", "miehe"]),
            "\"kratos\"",
            "of the mixed formulation: p = kappa (J - 1) or p = kappa (1 - 1/J)",
        ),
        Key::new("compressible", Kind::Bool, "true", "explicit: the volume follows the deformation"),
        Key::new("axis_symmetric_flag", Kind::Bool, "false", "axisymmetric about the y axis, x is the radius"),
        Key::new(
            "frame",
            Kind::Choice(&["updated_lagrangian", "total_lagrangian"]),
            "\"updated_lagrangian\"",
            "where the grid's functions are evaluated: at the present place of a point, or for ever at its first",
        ),
        Key::optional(
            "grid_reset",
            Kind::Choice(&["every_step", "never"]),
            "whether the grid goes back after each step, or moves on with the body: frame updated_lagrangian or \
             total_lagrangian by another name",
        ),
        Key::new(
            "basis",
            Kind::Choice(&["mesh", "lagrange", "b_spline"]),
            "\"mesh\"",
            "functions of the grid: of the mesh's cells, or of higher order on a regular grid",
        ),
        Key::new("basis_order", Kind::Integer { min: 1 }, "2", "degree of lagrange and b_spline"),
        Key::new(
            "transfer",
            Kind::Choice(&["flip", "pic", "apic", "tpic", "xpic"]),
            "\"flip\"",
            "explicit: how velocity returns to the points",
        ),
        Key::new(
            "flip_fraction",
            Kind::Number(Range::FRACTION),
            "1.0",
            "dynamic: share of FLIP in the velocity of the points, the rest is PIC",
        ),
        Key::new("xpic_order", Kind::Integer { min: 1 }, "5", "xpic: number of projections"),
        Key::new(
            "position_update",
            Kind::Choice(&["grid", "point"]),
            "\"grid\"",
            "explicit: points move with the velocity of the grid, or with their own as in Nuttall 2025",
        ),
        Key::new(
            "point_placement",
            Kind::Choice(&["gauss", "even"]),
            "\"gauss\"",
            "points at integration points of the body's cells, or evenly spaced with equal shares",
        ),
        Key::new("consistent_mass_matrix", Kind::Bool, "false", "consistent instead of lumped mass"),
        Key::new("block_builder", Kind::Bool, "true", "accepted; both give the same result"),
        Key::new("move_mesh_flag", Kind::Bool, "false", "accepted; the grid never moves"),
        Key::new("problem_domain_sub_model_part_list", Kind::List, "[]", "accepted"),
        Key::new("processes_sub_model_part_list", Kind::List, "[]", "accepted"),
        Key::new("auxiliary_variables_list", Kind::Texts, "[]", "accepted; columns are allocated on demand"),
        Key::new("auxiliary_dofs_list", Kind::Texts, "[]", "accepted"),
        Key::new("auxiliary_reaction_list", Kind::Texts, "[]", "accepted"),
        Key::optional(
            "lost_points",
            Kind::Choice(&["erase", "error", "clamp"]),
            "what becomes of points that leave the grid: erased with their mass (as remove_entities_not_found has \
             it by default), the run stops, or they go back to the border as to a smooth wall",
        )
        .adjustable(),
        Key::optional("linear_solver_settings", Kind::Any, "the linear solver").adjustable(),
        Key::new("element_search_settings", Kind::Object(SEARCH), "{}", "the search"),
        Key::new("model_import_settings", Kind::Object(MESH_IMPORT), "{}", "mesh of the bodies")
            .or(&["initial_model_import_settings"]),
        Key::new("grid_model_import_settings", Kind::Object(MESH_IMPORT), "{}", "mesh of the background grid"),
        Key::new("material_import_settings", Kind::Object(MATERIAL_IMPORT), "{}", "materials"),
    ],
);
