#pragma once

namespace raybundle::bench {

struct Workload;

/// What a kernel cannot do without.
struct Work {
  double bytes;  ///< to and from memory, when every array is read or written once
  double flops;  ///< multiplications, additions and divisions, as the formulas need them
};

Work linearize_work(const Workload& w);
Work cost_work(const Workload& w);
Work prepare_work(const Workload& w);
Work gradient_work(const Workload& w);
Work apply_work(const Workload& w);
Work diagonal_work(const Workload& w);
Work assemble_work(const Workload& w);
Work expand_work(const Workload& w);

}  // namespace raybundle::bench
