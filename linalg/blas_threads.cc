#include <raybundle/linalg/blas_threads.h>

#include <dlfcn.h>

#include <mutex>

namespace raybundle::linalg {
namespace {

// A function of whichever BLAS the program has loaded; null when it has none of that name.
template <class Function>
Function* find(const char* symbol) {
  return reinterpret_cast<Function*>(dlsym(RTLD_DEFAULT, symbol));
}

struct ThreadControl {
  int (*get)();
  void (*set)(int);
};

ThreadControl find_control() {
  return {find<int()>("openblas_get_num_threads"), find<void(int)>("openblas_set_num_threads")};
}

const ThreadControl& control() {
  static const ThreadControl found = find_control();
  return found;
}

// How many levels of OpenMP loops run in parallel: with 0 none does.
const ThreadControl& openmp() {
  static const ThreadControl found = {find<int()>("omp_get_max_active_levels"),
                                      find<void(int)>("omp_set_max_active_levels")};
  return found;
}

// The BLAS setting belongs to the process: the first guard saves it, the last one restores it.
struct Holders {
  std::mutex mutex;
  int count = 0;
  int previous = 0;
};

Holders& holders() {
  static Holders all;
  return all;
}

}  // namespace

SingleThreadedBlas::SingleThreadedBlas() {
  if (openmp().get != nullptr && openmp().set != nullptr) {
    openmp_levels_ = openmp().get();
    if (openmp_levels_ > 0) openmp().set(0);
  }
  if (control().get == nullptr || control().set == nullptr) return;
  const std::lock_guard lock(holders().mutex);
  if (holders().count++ > 0) return;
  holders().previous = control().get();
  if (holders().previous > 1) control().set(1);
}

SingleThreadedBlas::~SingleThreadedBlas() {
  if (openmp_levels_ > 0) openmp().set(openmp_levels_);
  if (control().get == nullptr || control().set == nullptr) return;
  const std::lock_guard lock(holders().mutex);
  if (--holders().count > 0) return;
  if (holders().previous > 1) control().set(holders().previous);
}

std::string blas_name() {
  if (auto* core = find<char*()>("openblas_get_corename")) {
    return std::string("OpenBLAS with kernels for ") + core();
  }
  if (find<char*()>("bli_info_get_version_str")) return "BLIS";
  if (find<void()>("ATL_dgemm")) return "ATLAS";
  return "an unknown BLAS";
}

}  // namespace raybundle::linalg
