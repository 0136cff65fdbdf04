//! Newmark's time integration with Bossak's damping.

/// Coefficients of Newmark's scheme, with Bossak's alpha (Wood, Bossak & Zienkiewicz 1980):
/// the inertia is taken at (1 - alpha) a + alpha a0.
///
/// v = c1 u - c4 v0 - c5 a0 and a = c0 u - c2 v0 - c3 a0, where u is the increment of the step
/// and v0, a0 are velocity and acceleration at its start.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Newmark {
    /// Bossak's alpha, 0 or negative; 0 is plain Newmark.
    pub alpha: f64,
    /// beta for alpha = 0.
    pub beta: f64,
}

/// The coefficients for one time step.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Coefficients {
    /// 1 / (beta dt²).
    pub c0: f64,
    /// gamma / (beta dt).
    pub c1: f64,
    /// 1 / (beta dt).
    pub c2: f64,
    /// 1 / (2 beta) - 1.
    pub c3: f64,
    /// gamma / beta - 1.
    pub c4: f64,
    /// (dt / 2)(gamma / beta - 2).
    pub c5: f64,
}

impl Newmark {
    /// Weight of the new acceleration in the velocity: 1/2 - alpha.
    pub fn gamma(&self) -> f64 {
        0.5 - self.alpha
    }

    /// Coefficients for the step `dt` in seconds: beta (1 - alpha)² and gamma = 1/2 - alpha keep
    /// second order for every alpha.
    pub fn coefficients(&self, dt: f64) -> Coefficients {
        let beta = (1.0 - self.alpha).powi(2) * self.beta;
        let gamma = self.gamma();
        Coefficients {
            c0: 1.0 / (beta * dt * dt),
            c1: gamma / (beta * dt),
            c2: 1.0 / (beta * dt),
            c3: 1.0 / (2.0 * beta) - 1.0,
            c4: gamma / beta - 1.0,
            c5: 0.5 * dt * (gamma / beta - 2.0),
        }
    }
}

impl Coefficients {
    /// Velocities and accelerations at the end of the step from the increments of the unknowns and
    /// the velocities and accelerations at its start.
    pub fn motion(&self, increments: &[f64], v0: &[f64], a0: &[f64]) -> (Vec<f64>, Vec<f64>) {
        let old = v0.iter().zip(a0);
        let both = increments.iter().zip(old);
        both.map(|(&u, (&v0, &a0))| (self.velocity(u, v0, a0), self.acceleration(u, v0, a0))).unzip()
    }

    /// Of the mid-point rule u = dt (v0 + v)/2 with one acceleration a = (v - v0)/dt for the whole
    /// step; a0 does not matter.
    pub fn midpoint(dt: f64) -> Self {
        Self { c0: 2.0 / (dt * dt), c1: 2.0 / dt, c2: 2.0 / dt, c3: 0.0, c4: 1.0, c5: 0.0 }
    }

    /// Of the backward Euler method, which does not look at a0: v = u/dt, a = (v - v0)/dt.
    pub fn backward_euler(dt: f64) -> Self {
        Self { c0: 1.0 / (dt * dt), c1: 1.0 / dt, c2: 1.0 / dt, c3: 0.0, c4: 0.0, c5: 0.0 }
    }

    /// Velocity at the end of the step.
    #[inline]
    pub fn velocity(&self, u: f64, v0: f64, a0: f64) -> f64 {
        self.c1 * u - self.c4 * v0 - self.c5 * a0
    }

    /// Acceleration at the end of the step.
    #[inline]
    pub fn acceleration(&self, u: f64, v0: f64, a0: f64) -> f64 {
        self.c0 * u - self.c2 * v0 - self.c3 * a0
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Error at t = 1 of x'' = -x, x(0) = 1, integrated in n steps.
    fn error(scheme: Newmark, n: usize) -> f64 {
        let dt = 1.0 / n as f64;
        let c = scheme.coefficients(dt);
        let (mut x, mut v, mut a): (f64, f64, f64) = (1.0, 0.0, -1.0);
        for _ in 0..n {
            // (1 - alpha) a + alpha a0 + (x + u) = 0 solved for u.
            let keep = 1.0 - scheme.alpha;
            let u = (keep * (c.c2 * v + c.c3 * a) - scheme.alpha * a - x) / (keep * c.c0 + 1.0);
            (x, v, a) = (x + u, c.velocity(u, v, a), c.acceleration(u, v, a));
        }
        (x - 1f64.cos()).abs()
    }

    #[test]
    fn both_schemes_are_second_order() {
        for alpha in [0.0, -0.3] {
            let scheme = Newmark { alpha, beta: 0.25 };
            let order = (error(scheme, 40) / error(scheme, 80)).log2();
            assert!((order - 2.0).abs() < 0.05, "alpha {alpha}: order {order}");
        }
    }

    #[test]
    fn a_constant_acceleration_is_exact() {
        let c = Newmark { alpha: 0.0, beta: 0.25 }.coefficients(0.1);
        let (v0, g) = (2.0, -9.81);
        let u = v0 * 0.1 + 0.5 * g * 0.01;
        assert!((c.velocity(u, v0, g) - (v0 + 0.1 * g)).abs() < 1e-12);
        assert!((c.acceleration(u, v0, g) - g).abs() < 1e-9);
    }

    #[test]
    fn backward_euler_forgets_the_acceleration() {
        let c = Coefficients::backward_euler(0.1);
        let (v0, g) = (2.0, -9.81);
        let u = (v0 + 0.1 * g) * 0.1;
        assert!((c.velocity(u, v0, 1e9) - (v0 + 0.1 * g)).abs() < 1e-12);
        assert!((c.acceleration(u, v0, 1e9) - g).abs() < 1e-9);
    }
}
