#include <chrono>
#include <functional>

#include <Eigen/Core>
#include <Eigen/SparseCore>

#include <raybundle/bench/qu18/probe.h>

namespace raybundle::bench {
namespace {

using linalg::index;
using linalg::Side;
using Sparse = Eigen::SparseMatrix<double>;
using Triplets = std::vector<Eigen::Triplet<double>>;

double seconds_of(const std::function<void()>& work) {
  const auto start = std::chrono::steady_clock::now();
  work();
  return std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
}

/// Calls visit(row, column, value) for every number of the blocks.
template <class Visit>
void visit_entries(const Linearised& at, Visit&& visit) {
  const linalg::BlockLayout& layout = at.layout();
  for (std::int64_t c = 0; c < layout.couplings; ++c) {
    const bool repeats = !layout.coupling_rows.empty();
    const std::int64_t first = repeats ? layout.coupling_rows[index(c)] : c;
    const std::int64_t last = repeats ? layout.coupling_rows[index(c + 1)] : c + 1;
    for (const Side side : {Side::hubs, Side::leaves}) {
      const int size = layout.block_size(side);
      const std::int64_t column =
          layout.offset(side) + std::int64_t{layout.incidence(side).block[index(c)]} * size;
      for (std::int64_t row = first; row < last; ++row) {
        for (int r = 0; r < layout.row_size; ++r) {
          for (int k = 0; k < size; ++k) {
            visit(row * layout.row_size + r, column + k, at.J.at(side, row, r, k));
          }
        }
      }
    }
  }
}

Eigen::MatrixXd dense_jacobian(const Linearised& at) {
  Eigen::MatrixXd J = Eigen::MatrixXd::Zero(at.layout().residuals(), at.layout().unknowns());
  visit_entries(at, [&](std::int64_t i, std::int64_t j, double value) { J(i, j) = value; });
  return J;
}

double bytes(const Eigen::MatrixXd& M) { return 8.0 * static_cast<double>(M.size()); }
double bytes(const Sparse& M) {
  return 12.0 * static_cast<double>(M.nonZeros()) + 4.0 * static_cast<double>(M.outerSize() + 1);
}
template <class Allocator>
double bytes(const std::vector<double, Allocator>& values) {
  return 8.0 * static_cast<double>(values.size());
}
double bytes(const linalg::Incidence& side) {
  return 8.0 * static_cast<double>(side.begin.size()) +
         4.0 * static_cast<double>(side.list.size() + side.block.size());
}

Json entry(const char* name, double seconds, double bytes) {
  return {{"form", name}, {"seconds", seconds}, {"bytes", bytes}};
}

}  // namespace

Json matrix_forms(const Problem& problem, linalg::ThreadPool& pool) {
  Linearised at(problem, pool);
  const State state = at.objective.state_of(problem);
  const auto derivatives = [&] { at.at(state); };
  derivatives();  // memory that is touched for the first time counts for nobody
  const auto n = at.layout().unknowns();
  Json forms = Json::array();
  Sparse reference;
  {
    Triplets triplets;
    Sparse J(at.layout().residuals(), n);
    const double seconds = seconds_of([&] {
      derivatives();
      visit_entries(at, [&](std::int64_t i, std::int64_t j, double value) {
        if (value != 0) triplets.emplace_back(static_cast<int>(i), static_cast<int>(j), value);
      });
      J.setFromTriplets(triplets.begin(), triplets.end());
      reference = J.transpose() * J;
    });
    forms.push_back(entry("IS-sparse", seconds, bytes(J) + bytes(reference)));
  }
  {
    Sparse J, H;
    const double seconds = seconds_of([&] {
      derivatives();
      J = dense_jacobian(at).sparseView();
      H = J.transpose() * J;
    });
    forms.push_back(entry("ES-sparse", seconds, bytes(J) + bytes(H)));
  }
  double difference = 0;
  {
    Eigen::MatrixXd J, H;
    const double seconds = seconds_of([&] {
      derivatives();
      J = dense_jacobian(at);
      H.noalias() = J.transpose() * J;
    });
    forms.push_back(entry("ES", seconds, bytes(J) + bytes(H)));
    difference = (H - reference).norm() / reference.norm();
  }
  {
    const double seconds = seconds_of([&] { at.at(state); });
    const linalg::BlockLayout& layout = at.layout();
    const linalg::LayoutSize size = {{layout.row_size, layout.hub_size, layout.leaf_size},
                                     layout.hubs,
                                     layout.leaves,
                                     layout.rows};
    const double held = linalg::BlockJacobian::memory(size, at.J.precision()) + bytes(at.normal.C) +
                        bytes(at.layout().hub_side) + bytes(at.layout().leaf_side);
    forms.push_back(entry("IS-cell", seconds, held));
  }
  return {{"rows", at.layout().residuals()},
          {"columns", n},
          {"relative_difference", difference},
          {"forms", std::move(forms)}};
}

}  // namespace raybundle::bench
