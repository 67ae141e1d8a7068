// SPDX-License-Identifier: Apache-2.0
#include "tools/calibrate/least_squares.hpp"

#include <Eigen/Cholesky>

#include <algorithm>
#include <cmath>
#include <limits>

namespace afterglow {
namespace {

constexpr double outlier = 3;      ///< c of the loss
constexpr double step_size = 1e-6; ///< of central differences, relative to 1 + |x|
constexpr double settled = 1e-7;   ///< relative change of the cost
constexpr double largest_damping = 1e12;

double loss(double r) {
    return outlier * outlier * std::log1p(r * r / (outlier * outlier));
}
double weight(double r) {
    return 1 / (1 + r * r / (outlier * outlier));
}

double cost_of(const Eigen::VectorXd &x, const std::vector<ResidualBlock> &blocks) {
    double sum = 0;
    Eigen::VectorXd r;
    for (const ResidualBlock &block : blocks) {
        r.resize(block.count);
        block.evaluate(x, r);
        for (const double each : r)
            sum += loss(each);
    }
    return std::isfinite(sum) ? sum : std::numeric_limits<double>::infinity();
}

/// J^T W J and J^T W r of all residuals at x.
struct NormalEquations {
    Eigen::MatrixXd H;
    Eigen::VectorXd g;
};

Eigen::MatrixXd jacobian(Eigen::VectorXd &x, const ResidualBlock &block) {
    Eigen::MatrixXd J(block.count, static_cast<int>(block.parameters.size()));
    Eigen::VectorXd ahead(block.count), behind(block.count);
    for (std::size_t k = 0; k < block.parameters.size(); ++k) {
        double &moved = x[block.parameters[k]];
        const double here = moved, step = step_size * (1 + std::abs(here));
        moved = here + step;
        block.evaluate(x, ahead);
        moved = here - step;
        block.evaluate(x, behind);
        moved = here;
        J.col(static_cast<int>(k)) = (ahead - behind) / (2 * step);
    }
    return J;
}

NormalEquations normal_equations(Eigen::VectorXd x, const std::vector<ResidualBlock> &blocks) {
    NormalEquations sum = {Eigen::MatrixXd::Zero(x.size(), x.size()),
                           Eigen::VectorXd::Zero(x.size())};
    Eigen::VectorXd r;
    for (const ResidualBlock &block : blocks) {
        const Eigen::MatrixXd J = jacobian(x, block);
        r.resize(block.count);
        block.evaluate(x, r);
        const Eigen::VectorXd w = r.unaryExpr([](double each) { return weight(each); });
        const Eigen::MatrixXd weighted = w.asDiagonal() * J;
        const Eigen::MatrixXd H = J.transpose() * weighted;
        const Eigen::VectorXd g = weighted.transpose() * r;
        for (std::size_t a = 0; a < block.parameters.size(); ++a) {
            sum.g[block.parameters[a]] += g[static_cast<int>(a)];
            for (std::size_t b = 0; b < block.parameters.size(); ++b)
                sum.H(block.parameters[a], block.parameters[b]) +=
                    H(static_cast<int>(a), static_cast<int>(b));
        }
    }
    return sum;
}

/// The square roots of the diagonal of H^-1, where a parameter that no residual depends on has a
/// row of zeros in H. H is scaled to a unit diagonal first: parameters differ in size.
Eigen::VectorXd standard_deviations(const Eigen::MatrixXd &H) {
    const Eigen::VectorXd scale =
        H.diagonal().unaryExpr([](double d) { return d > 0 ? 1 / std::sqrt(d) : 0.0; });
    Eigen::MatrixXd scaled = scale.asDiagonal() * H * scale.asDiagonal();
    for (int i = 0; i < scaled.rows(); ++i)
        scaled(i, i) = 1;
    const Eigen::LDLT<Eigen::MatrixXd> solver(scaled);
    const bool determined = solver.info() == Eigen::Success && solver.isPositive() &&
                            solver.vectorD().minCoeff() > 1e-13;
    if (!determined)
        return Eigen::VectorXd::Constant(H.rows(), std::numeric_limits<double>::infinity());
    const Eigen::MatrixXd inverse = solver.solve(Eigen::MatrixXd::Identity(H.rows(), H.cols()));
    return inverse.diagonal().cwiseMax(0).cwiseSqrt().cwiseProduct(scale);
}

} // namespace

LeastSquaresFit least_squares(const Eigen::VectorXd &start,
                              const std::vector<ResidualBlock> &blocks, int most_iterations) {
    LeastSquaresFit fit;
    fit.x = start;
    double cost = cost_of(start, blocks), damping = 1e-4;
    NormalEquations equations = normal_equations(fit.x, blocks);
    for (int i = 0; i < most_iterations && !fit.converged; ++i) {
        double gain = 0;
        while (damping < largest_damping) {
            Eigen::MatrixXd damped = equations.H;
            damped.diagonal() += damping * equations.H.diagonal();
            damped.diagonal().array() += std::numeric_limits<double>::min();
            const Eigen::VectorXd next = fit.x - damped.ldlt().solve(equations.g);
            const double next_cost =
                next.allFinite() ? cost_of(next, blocks) : std::numeric_limits<double>::infinity();
            if (next_cost <= cost) {
                gain = cost - next_cost;
                fit.x = next;
                cost = next_cost;
                damping = std::max(damping / 10, 1e-12);
                break;
            }
            damping *= 10;
        }
        fit.converged = std::isfinite(cost) && gain <= settled * cost;
        equations = normal_equations(fit.x, blocks);
    }
    int count = 0;
    for (const ResidualBlock &block : blocks)
        count += block.count;
    fit.cost = count > 0 ? cost / count : 0;
    fit.sigma = standard_deviations(equations.H);
    return fit;
}

} // namespace afterglow
