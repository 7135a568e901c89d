#include <raybundle/linalg/reduced_system.h>

#include <raybundle/linalg/full_system.h>
#include <raybundle/linalg/schur_complement.h>

#include <stdexcept>

namespace raybundle::linalg {

const double* ReducedSystem::coarse_matrix(const CoarseBasis& /*basis*/) {
  throw std::logic_error("a coarse space is one of hubs, with the leaves eliminated");
}

std::unique_ptr<ReducedSystem> make_reduced_system(const BlockLayout& layout,
                                                   std::optional<Side> eliminated,
                                                   ThreadPool& pool) {
  if (eliminated) return std::make_unique<SchurComplement>(layout, *eliminated, pool);
  return std::make_unique<FullSystem>(layout, pool);
}

double reduced_system_memory(const LayoutSize& n, std::optional<Side> eliminated, bool assembled) {
  return eliminated ? SchurComplement::memory(n, *eliminated, assembled) : FullSystem::memory(n);
}

}  // namespace raybundle::linalg
