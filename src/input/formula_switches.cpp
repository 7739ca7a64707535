#include <algorithm>
#include <cmath>
#include <utility>

#include "input/formula_tree.hpp"

namespace viscobar {

namespace {

using Operation = FormulaTree::Operation;

constexpr int thorough = 4096;  // evaluations of a search before it becomes coarse

bool switches(const FormulaTree::Node& node) {
  return (is_condition(node.operation) && node.operation < Operation::both) || node.operation >= Operation::abs;
}

}  // namespace

FormulaSwitches::FormulaSwitches(std::shared_ptr<const FormulaTree> tree, Of of)
    : tree_(std::move(tree)), along_x_(of == Of::along_x) {
  for (const FormulaTree::Node& node : tree_->nodes)
    if (switches(node) && (along_x_ ? node.uses_x : node.uses_t && node.uses_x == (of == Of::at_x)))
      switches_.push_back(static_cast<int>(&node - tree_->nodes.data()));
}

class FormulaSwitches::Search {
 public:
  Search(const FormulaSwitches& of, double other, double length)
      : of_(of),
        tree_(*of.tree_),
        all_(tree_.size()),
        jets_(tree_.of_nodes(all_.data())),
        other_(Interval(other), {}),
        coarse_(length / 1024) {}

  std::optional<double> first_within(double begin, double end) {
    bound({begin, end});
    ++effort_;
    open_.clear();
    bool monotone = true;
    for (const int g : of_.switches_) {
      const auto [value, slope] = argument(g);
      if (value.low > 0.0 || value.high <= 0.0 || slope.is(0.0) || excluded(node(g).branch)) continue;
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
    for (const int g : open_) {
      const auto found = flip(g, begin, end);
      if (found && (!first || *found < *first)) first = found;
    }
    return first;
  }

 private:
  void bound(Interval s) {
    const Jet along(s, Interval(1.0));
    tree_.evaluate(of_.along_x_ ? along : other_, of_.along_x_ ? other_ : along, jets_, FormulaTree::bound,
                   [](std::size_t, Jet&) {});
  }

  const FormulaTree::Node& node(int index) const { return tree_.nodes[static_cast<std::size_t>(index)]; }
  Jet argument(int of) const {
    const Jet& a = jets_[node(of).of[0]];
    return node(of).operands == 1 ? a : a - jets_[node(of).of[1]];
  }
  double argument_at(int node, double s) {
    bound(Interval(s));
    return argument(node).value.low;
  }

  // True if a branch is surely not taken, by the jets.
  bool excluded(int branch) const {
    for (; branch >= 0; branch = tree_.branches[static_cast<std::size_t>(branch)].outer) {
      const FormulaTree::Branch& of = tree_.branches[static_cast<std::size_t>(branch)];
      if (truth(jets_[of.condition].value).is(of.when ? 0.0 : 1.0)) return true;
    }
    return false;
  }

  // The number at which g is least, of the two next to each other between which g > 0 changes.
  std::optional<double> flip(int g, double begin, double end) {
    double at_begin = argument_at(g, begin), at_end = argument_at(g, end);
    if ((at_begin > 0.0) == (at_end > 0.0)) return std::nullopt;
    while (true) {
      const double middle = begin + (end - begin) / 2;
      if (!(begin < middle && middle < end)) break;
      const double value = argument_at(g, middle);
      if ((value > 0.0) == (at_begin > 0.0))
        begin = middle, at_begin = value;
      else
        end = middle, at_end = value;
    }
    const double root = std::abs(at_begin) < std::abs(at_end) ? begin : end;
    argument_at(g, root);
    return excluded(node(g).branch) ? std::nullopt : std::optional(root);
  }

  const FormulaSwitches& of_;
  const FormulaTree& tree_;
  std::vector<Jet> all_;
  Jet* const jets_;        // of the nodes
  std::vector<int> open_;  // those that may change sign
  const Jet other_;
  const double coarse_;
  int effort_ = 0;
};

std::optional<double> FormulaSwitches::first(double other, double after, double until) const {
  return Search(*this, other, until - after).first_within(after, until);
}

}  // namespace viscobar
