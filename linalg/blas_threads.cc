#include <raybundle/linalg/blas_threads.h>

#include <dlfcn.h>

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
  ThreadControl openblas = {find<int()>("openblas_get_num_threads"),
                            find<void(int)>("openblas_set_num_threads")};
  return openblas;
}

const ThreadControl& control() {
  static const ThreadControl found = find_control();
  return found;
}

}  // namespace

SingleThreadedBlas::SingleThreadedBlas() {
  if (control().get == nullptr || control().set == nullptr) return;
  previous_ = control().get();
  if (previous_ > 1) control().set(1);
}

SingleThreadedBlas::~SingleThreadedBlas() {
  if (previous_ > 1) control().set(previous_);
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
