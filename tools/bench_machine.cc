#include <raybundle/tools/bench_machine.h>

#include <sys/utsname.h>
#include <unistd.h>

#include <fstream>

#include <nlohmann/json.hpp>

#include <raybundle/linalg/blas_threads.h>
#include <raybundle/linalg/cpu.h>
#include <raybundle/linalg/parallel.h>
#include <raybundle/models/error.h>
#include <raybundle/version.h>

namespace raybundle::tools {
namespace {

using Json = nlohmann::ordered_json;

void visit_members(auto& machine, auto&& visit) {
  visit("processor", machine.processor);
  visit("cores", machine.cores);
  visit("memory_bytes", machine.memory);
  visit("instruction_set", machine.instruction_set);
  visit("blas", machine.blas);
  visit("system", machine.system);
  visit("version", machine.version);
  visit("build", machine.build);
}

/// What follows `separator` in the first line that begins with `key`; empty: no such line.
std::string value_in(const char* file, const std::string& key, char separator) {
  std::ifstream in(file);
  for (std::string line; std::getline(in, line);) {
    const std::size_t at = line.find(separator);
    if (!line.starts_with(key) || at == std::string::npos) continue;
    const std::size_t first = line.find_first_not_of(" \t\"", at + 1);
    const std::size_t last = line.find_last_not_of(" \t\"");
    if (first == std::string::npos) return "";
    return line.substr(first, last + 1 - first);
  }
  return "";
}

std::string system_name() {
  struct utsname kernel {};
  ::uname(&kernel);
  const std::string distribution = value_in("/etc/os-release", "PRETTY_NAME=", '=');
  return (distribution.empty() ? "" : distribution + ", ") + kernel.sysname + " " + kernel.release +
         " " + kernel.machine;
}

}  // namespace

Machine this_machine() {
  Machine machine;
  machine.processor = value_in("/proc/cpuinfo", "model name", ':');
  if (machine.processor.empty()) machine.processor = "unknown";
  machine.cores = static_cast<int>(linalg::available_threads());
  machine.memory = std::int64_t{::sysconf(_SC_PHYS_PAGES)} * ::sysconf(_SC_PAGE_SIZE);
  machine.instruction_set = linalg::name(linalg::instruction_set());
  machine.blas = linalg::blas_name();
  machine.system = system_name();
  machine.version = version;
  machine.build = build_description;
  return machine;
}

std::string to_json(const Machine& machine) {
  Json json;
  visit_members(machine, [&](const char* name, const auto& value) { json[name] = value; });
  return json.dump(1, ' ', false, Json::error_handler_t::replace) + "\n";
}

Machine machine_from_json(const std::string& text, const std::string& source) {
  Machine machine;
  try {
    const Json json = Json::parse(text);
    visit_members(machine, [&](const char* name, auto& value) { json.at(name).get_to(value); });
  } catch (const Json::exception& error) {
    throw InputError(source, 0, error.what(), "a description of a machine");
  }
  return machine;
}

}  // namespace raybundle::tools
