// Reads randomly damaged BAL files and solves what can be read, to be run under the sanitizers:
//   mutate_bal [--count N] [--seed S] [FILE]
// Damages FILE (or, without one, a generated problem) N times. Each text must give an InputError or
// a valid problem whose solve ends in finite numbers and at no higher cost; the first that does not
// is left in ./mutate_bal-failure.txt, with exit code 1.
// Round i of seed S is round 0 of seed S + i.

#include <algorithm>
#include <charconv>
#include <chrono>
#include <cstdint>
#include <exception>
#include <fstream>
#include <iostream>
#include <stdexcept>
#include <string>
#include <vector>

#include <raybundle/models/io/file_content.h>
#include <raybundle/solver/solve.h>
#include <raybundle/tests/support/bal_check.h>
#include <raybundle/tests/support/mutate.h>
#include <raybundle/tests/support/random_problem.h>

namespace {

struct Arguments {
  std::uint64_t count = 2000;
  std::uint64_t seed = 1;
  std::string file;
};

std::uint64_t parse_number(const std::string& text) {
  std::uint64_t value = 0;
  const auto [last, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (error != std::errc() || last != text.data() + text.size()) {
    throw std::invalid_argument("not a number: " + text);
  }
  return value;
}

Arguments parse(const std::vector<std::string>& words) {
  Arguments arguments;
  for (std::size_t i = 0; i < words.size(); ++i) {
    const bool has_value = i + 1 < words.size();
    if (words[i] == "--count" && has_value) {
      arguments.count = parse_number(words[++i]);
    } else if (words[i] == "--seed" && has_value) {
      arguments.seed = parse_number(words[++i]);
    } else if (!words[i].starts_with("--") && arguments.file.empty()) {
      arguments.file = words[i];
    } else {
      throw std::invalid_argument("usage: mutate_bal [--count N] [--seed S] [FILE]");
    }
  }
  return arguments;
}

// A damaged problem may be hopeless, but its solve ends in words and leaves nothing worse.
void solve_damaged(raybundle::Problem problem) {
  const raybundle::Summary summary = raybundle::solve(problem, {.max_iterations = 4, .threads = 1});
  raybundle::validate(problem);
  if (summary.termination == raybundle::Termination::bad_start) return;
  if (!(summary.final_cost <= summary.initial_cost)) {
    throw std::logic_error("the solve raised the cost");
  }
}

int run(const Arguments& arguments) {
  using raybundle::test::random_problem;
  const std::string original = arguments.file.empty()
                                   ? raybundle::test::bal_text(random_problem(1, 5, 20, 60))
                                   : std::string(raybundle::io::FileContent(arguments.file).text());
  std::uint64_t read = 0;
  double slowest = 0;
  for (std::uint64_t i = 0; i < arguments.count; ++i) {
    const std::string text = raybundle::test::Mutator(arguments.seed + i)(original);
    const auto start = std::chrono::steady_clock::now();
    try {
      const auto problem = raybundle::test::read_or_refuse(text);
      if (problem) {
        ++read;
        solve_damaged(*problem);
      }
    } catch (const std::exception& error) {
      std::ofstream("mutate_bal-failure.txt", std::ios::binary) << text;
      std::cerr << "seed " << arguments.seed + i << ": " << error.what() << "\n";
      return 1;
    }
    const std::chrono::duration<double> seconds = std::chrono::steady_clock::now() - start;
    slowest = std::max(slowest, seconds.count());
  }
  std::cout << arguments.count << " mutations of " << original.size() << " bytes: " << read
            << " read and solved, " << arguments.count - read << " refused, slowest " << slowest
            << " s\n";
  return 0;
}

}  // namespace

int main(int argc, char** argv) {
  try {
    return run(parse({argv + 1, argv + argc}));
  } catch (const std::exception& error) {
    std::cerr << "mutate_bal: " << error.what() << "\n";
    return 2;
  }
}
