#pragma once

#include <cstdint>
#include <new>
#include <string>

namespace raybundle::linalg {

/// Memory that would be needed and is not there; refused before it is asked for, because a system
/// that overcommits kills the process instead of failing the allocation.
class MemoryRefusal : public std::bad_alloc {
 public:
  explicit MemoryRefusal(std::string message) : message_(std::move(message)) {}
  const char* what() const noexcept override { return message_.c_str(); }

 private:
  std::string message_;
};

/// Bytes that this process can still take: what the system has without swapping, or what control
/// groups or the process's own limits of data and address space leave, if that is less; the largest
/// number where nobody says. Reads a few small files of the system.
double available_memory();

/// Bytes of this process that are in memory now.
double resident_memory();

/// "1.4 GB", "32.0 MB", "0.5 kB".
std::string memory_text(double bytes);

/// Throws MemoryRefusal when `bytes` are more than is available; `what` names their purpose.
void require_memory(double bytes, const std::string& what);
/// The same of `left`, which is what all else leaves.
void require_memory(double bytes, double left, const std::string& what);

}  // namespace raybundle::linalg
