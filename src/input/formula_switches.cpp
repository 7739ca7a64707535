#include <utility>

#include "input/formula_tree.hpp"

namespace viscobar {

namespace {

using Operation = FormulaTree::Operation;

constexpr int thorough = 4096;  // evaluations of a search before it becomes coarse

bool takes_two(Operation operation) {
  return is_comparison(operation) || operation == Operation::min || operation == Operation::max;
}

}  // namespace

template <class Counts>
FormulaSwitches::FormulaSwitches(FormulaTree tree, bool along_x, Counts&& counts)
    : tree_(std::move(tree)), along_x_(along_x) {
  for (std::size_t i = 0, count = tree_.nodes.size(); i < count; ++i) {
    const FormulaTree::Node node = tree_.nodes[i];
    if (!counts(node)) continue;
    if (takes_two(node.operation)) {
      FormulaTree::Node difference = node;
      difference.operation = Operation::subtract;
      switches_.push_back(tree_.nodes.size());
      tree_.nodes.push_back(difference);
    } else if (node.operation == Operation::abs) {
      switches_.push_back(static_cast<std::size_t>(node.a));
    }
  }
  jets_.resize(tree_.nodes.size());
}

FormulaSwitches::FormulaSwitches(FormulaTree tree, bool with_x)
    : FormulaSwitches(std::move(tree), false,
                      [with_x](const FormulaTree::Node& node) { return node.uses_t && node.uses_x == with_x; }) {}

FormulaSwitches FormulaSwitches::along_x(FormulaTree tree) {
  return {std::move(tree), true, [](const FormulaTree::Node& node) { return node.uses_x; }};
}

void FormulaSwitches::bound(Interval s) {
  const Jet along{s, {1.0, 1.0}}, other{{other_, other_}, {}};
  tree_.bound(along_x_ ? along : other, along_x_ ? other : along, jets_);
}

// Whether a branch is surely not taken, by the jets.
bool FormulaSwitches::excluded(int branch) const {
  for (; branch >= 0; branch = tree_.branches[branch].outer) {
    const auto taken = truth(jets_[tree_.branches[branch].condition].value);
    if (taken && *taken != tree_.branches[branch].when) return true;
  }
  return false;
}

std::optional<double> FormulaSwitches::first(double other, double after, double until) {
  other_ = other;
  effort_ = 0;
  coarse_ = (until - after) / 1024;
  return first_within(after, until);
}

std::optional<double> FormulaSwitches::first_within(double begin, double end) {
  bound({begin, end});
  ++effort_;
  open_.clear();
  bool monotone = true;
  for (const std::size_t g : switches_) {
    const auto [value, slope] = jets_[g];
    if (value.low > 0.0 || value.high <= 0.0 || slope.is(0.0) || excluded(tree_.nodes[g].branch)) continue;
    open_.push_back(g);
    monotone &= slope.low >= 0.0 || slope.high <= 0.0;
  }
  if (open_.empty()) return std::nullopt;
  const double middle = begin + (end - begin) / 2;
  const bool fine = !(begin < middle && middle < end) || (effort_ > thorough && end - begin <= coarse_);
  if (!monotone && !fine) {
    const auto found = first_within(begin, middle);
    return found ? found : first_within(middle, end);
  }
  std::optional<double> first;
  for (const std::size_t g : open_) {
    const auto found = flip(g, begin, end);
    if (found && (!first || *found < *first)) first = found;
  }
  return first;
}

double FormulaSwitches::argument_at(std::size_t argument, double s) {
  bound({s, s});
  return jets_[argument].value.low;
}

// The number at which g is least, of the two next to each other between which g > 0 changes.
std::optional<double> FormulaSwitches::flip(std::size_t argument, double begin, double end) {
  double at_begin = argument_at(argument, begin), at_end = argument_at(argument, end);
  if ((at_begin > 0.0) == (at_end > 0.0)) return std::nullopt;
  while (true) {
    const double middle = begin + (end - begin) / 2;
    if (!(begin < middle && middle < end)) break;
    const double value = argument_at(argument, middle);
    if ((value > 0.0) == (at_begin > 0.0))
      begin = middle, at_begin = value;
    else
      end = middle, at_end = value;
  }
  const double root = std::abs(at_begin) < std::abs(at_end) ? begin : end;
  argument_at(argument, root);
  return excluded(tree_.nodes[argument].branch) ? std::nullopt : std::optional(root);
}

}  // namespace viscobar
