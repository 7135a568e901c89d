#pragma once

#include <raybundle/linalg/block_jacobian.h>
#include <raybundle/linalg/normal_equations.h>
#include <raybundle/linalg/symmetric_blocks.h>

#include <memory>
#include <optional>
#include <vector>

namespace raybundle::linalg {

/// The linearisation a step is computed from; everything outlives the solve of the step.
struct Linearization {
  const BlockJacobian* J;
  const NormalEquations* normal;
  /// In which ways hubs move together at little cost: of each hub hub_size x coarse_modes(hub_size)
  /// numbers, row-major; null where nobody says.
  const double* hub_modes = nullptr;
};

/// A coarse space over the hubs: x = P c, with one block of P for each hub and one of c for each
/// cluster of hubs (HubClusters).
struct CoarseBasis {
  std::vector<std::int32_t> cluster;  ///< of a hub
  std::vector<double> P;              ///< hubs x (hub_size x modes), row-major
  SymmetricPattern pattern;           ///< of P^T A P
  std::int64_t most_clusters = 0;     ///< that one leaf touches
};

/// Square blocks along a diagonal, in runs of equal size.
struct DiagonalBlocks {
  struct Run {
    int size;
    std::int64_t count;
    std::vector<double> values;  ///< count x (size x size), symmetric
  };
  std::vector<Run> runs;
};

/// The system (H + D) p = -g after the elimination of one side, or of none:
///   A x = -v, with A = S_C or S_B [Qu18, Eq. 3.64-3.66, 3.70-3.72], or H + D itself.
/// D is a diagonal of all unknowns. Eliminating leaves and eliminating hubs is the same code with
/// the sides exchanged.
class ReducedSystem {
 public:
  virtual ~ReducedSystem() = default;

  /// Unknowns of x, and where they stand in a vector of all unknowns.
  virtual std::int64_t size() const = 0;
  virtual std::int64_t offset() const = 0;

  /// Takes a linearisation and a damping; what is needed by all below is computed here.
  virtual void prepare(const Linearization& at, const double* damping) = 0;

  /// v, without forming A.
  virtual void gradient(double* v) = 0;
  /// y = A x, without forming A.
  virtual void apply(const double* x, double* y) = 0;

  /// Sparsity of A. Throws MemoryRefusal when A cannot be held.
  virtual SymmetricPattern pattern() const = 0;
  /// A and v together.
  virtual void assemble(SymmetricBlocks& A, double* v) = 0;

  /// The full step p from x: back-substitution [Qu18, Eq. 3.67, 3.73]. Returns |J p|^2.
  virtual double expand(const double* x, double* step) = 0;

  /// The diagonal blocks of the damped H on the kept side.
  virtual void diagonal_blocks(DiagonalBlocks& out) = 0;
  /// Those of A, and v.
  virtual void reduced_diagonal(DiagonalBlocks& out, double* v) = 0;
  /// P^T A P, in the order of its pattern's blocks, modes x modes numbers each; valid until
  /// the next call. Only where the leaves are eliminated: throws std::logic_error otherwise.
  virtual const double* coarse_matrix(const CoarseBasis& basis);
};

/// `layout` and `pool` outlive the system. No side to eliminate: the full system.
std::unique_ptr<ReducedSystem> make_reduced_system(const BlockLayout& layout,
                                                   std::optional<Side> eliminated,
                                                   ThreadPool& pool);

/// Its bytes, for products or for explicit matrices alone.
double reduced_system_memory(const LayoutSize& n, std::optional<Side> eliminated, bool assembled);

}  // namespace raybundle::linalg
