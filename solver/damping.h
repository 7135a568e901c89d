#pragma once

namespace raybundle {

/// The damping factor mu and its update [Qu18, Alg. 6], after [Lourakis05]: a good step shrinks it
/// by up to 3, failures grow it by 2, 4, 8, ...
class Damping {
 public:
  Damping(double initial, double low) : mu_(initial < low ? low : initial), low_(low) {}

  double mu() const { return mu_; }
  /// `rho`: actual over predicted decrease; anything not above 0, NaN included, is a failure. A
  /// damping of 0 grows from a small number.
  void update(double rho);

 private:
  double mu_;
  double low_;
  double nu_ = 2;
};

}  // namespace raybundle
