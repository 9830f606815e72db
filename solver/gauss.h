// Gauss and Legendre's nodes on an interval.
#pragma once

namespace atrium {

// Gauss-Legendre nodes of [0, 1].
template <int kNodes>
struct Gauss;
template <>
struct Gauss<3> {
  static constexpr double node[] = {0.11270166537925831148, 0.5, 0.88729833462074168852};
  static constexpr double weight[] = {5.0 / 18, 8.0 / 18, 5.0 / 18};
};
template <>
struct Gauss<5> {
  static constexpr double node[] = {0.04691007703066800360, 0.23076534494715845448, 0.5,
                                    0.76923465505284154552, 0.95308992296933199640};
  static constexpr double weight[] = {0.11846344252809454376, 0.23931433524968323402, 64.0 / 225,
                                      0.23931433524968323402, 0.11846344252809454376};
};

}  // namespace atrium
