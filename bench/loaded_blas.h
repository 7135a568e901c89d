#pragma once

#include <dlfcn.h>

#include <algorithm>
#include <fstream>
#include <set>
#include <string>

/// Which BLAS a running program really uses (Linux). The answer belongs into every record of a
/// measurement: it changes dense linear algebra by a factor of eight.
namespace raybundle::bench {

/// Every loaded library whose name says BLAS or LAPACK.
inline std::set<std::string> loaded_blas() {
  std::set<std::string> found;
  std::ifstream maps("/proc/self/maps");
  for (std::string line; std::getline(maps, line);) {
    const std::string file = line.substr(std::min(line.find('/'), line.size()));
    for (const char* word : {"blas", "lapack", "blis", "atlas", "mkl"}) {
      if (file.find(word) != std::string::npos) found.insert(file);
    }
  }
  return found;
}

/// The library that answers calls of a BLAS routine: of several loaded, the first in the order
/// of the dynamic linker, which is not always the one /etc/alternatives names.
inline std::string library_of(const char* symbol) {
  void* address = dlsym(RTLD_DEFAULT, symbol);
  Dl_info info;
  return address != nullptr && dladdr(address, &info) != 0 ? info.dli_fname : "none";
}

/// The processor OpenBLAS has chosen its kernels for; empty for another BLAS.
inline std::string openblas_core() {
  void* address = dlsym(RTLD_DEFAULT, "openblas_get_corename");
  return address == nullptr ? "" : reinterpret_cast<char* (*)()>(address)();
}

}  // namespace raybundle::bench
