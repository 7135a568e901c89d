#pragma once

#include <string>

/// What control groups leave to this process: by them containers and batch systems share out a
/// machine. A group is limited by those above it too. Of both versions, where Linux mounts them.
namespace raybundle::linalg {

/// Bytes until the nearest limit, with cached files that nobody has used lately counted as free;
/// the largest number where there is no limit. `root` stands before all paths: for tests.
double control_group_memory(const std::string& root = "");

/// Processors by their quota of time, such as 1.5; the largest number where there is no quota.
double control_group_processors(const std::string& root = "");

}  // namespace raybundle::linalg
