// The store. A node leaves it when its last handle goes; children follow from a list, never by recursion.
#include "expr/node.h"

#include <algorithm>
#include <utility>
#include <mutex>
#include <unordered_map>

namespace irt {
namespace {

struct Table {
  std::mutex mutex;
  std::unordered_multimap<std::size_t, Node*> nodes;
};

Table& table() {
  static Table* t = new Table;  // outlives every handle in static storage
  return *t;
}

std::size_t mix(std::size_t h, std::size_t v) {
  h ^= v + 0x9e3779b97f4a7c15ull + (h << 6) + (h >> 2);
  return h * 0xff51afd7ed558ccdull;
}

std::size_t hash_text(std::size_t h, const std::string& text) {
  for (unsigned char c : text) h = (h ^ c) * 0x100000001b3ull;
  return h;
}

bool same(const Node& a, const Node& b) {
  return a.op == b.op && a.name == b.name && a.args == b.args && (!a.number || *a.number == *b.number);
}

// Whether the operator itself is defined wherever its arguments are.
bool total_operator(const Node& n) {
  switch (n.op) {
    case Op::Pow: {
      const Expr& exponent = n.args[1];
      if (exponent.op() != Op::Number) return false;
      const Expr& base = n.args[0];
      if (base.op() == Op::Number && sgn(base.number()) > 0) return true;
      return exponent.number().get_den() == 1 && sgn(exponent.number()) > 0;
    }
    case Op::Log:
    case Op::Tan:
    case Op::Asin:
    case Op::Acos:
    case Op::Atan2: return false;
    case Op::Mod: return n.args[1].op() == Op::Number && sgn(n.args[1].number()) != 0;
    case Op::Piecewise: return n.args.back().op() == Op::True;
    default: return true;
  }
}

constexpr std::int64_t kHeavy = std::int64_t{1} << 40;

std::int64_t weigh(const Node& n) {
  std::int64_t w = 0;
  switch (n.op) {
    case Op::Number:
    case Op::Pi:
    case Op::E: return 0;
    case Op::Symbol: return n.name == "x" || n.name == "y" || n.name == "z" ? 1 : 0;
    case Op::Mul:
      for (const Expr& a : n.args) w += a.key()->weight;
      break;
    case Op::Pow: {
      w = n.args[0].key()->weight;
      const Expr& e = n.args[1];
      if (e.op() == Op::Number && abs(e.number()) < 1'000'000) w = static_cast<std::int64_t>(static_cast<double>(w) * e.number().get_d());
      break;
    }
    default:
      for (const Expr& a : n.args) w = std::max(w, a.key()->weight);
  }
  return std::clamp(w, -kHeavy, kHeavy);
}

}  // namespace

void Store::retain(const Node* node) noexcept { const_cast<Node*>(node)->references.fetch_add(1, std::memory_order_relaxed); }

void Store::release(const Node* released) noexcept {
  // Counts above one fall without the lock. The last one falls under it, so that no one finds a node that is going.
  const auto shared = [](Node* node) {
    auto count = node->references.load(std::memory_order_relaxed);
    bool done = false;
    while (count > 1 && !done) done = node->references.compare_exchange_weak(count, count - 1, std::memory_order_acq_rel);
    return done;
  };
  if (shared(const_cast<Node*>(released))) return;
  std::vector<Node*> pending{const_cast<Node*>(released)};
  while (!pending.empty()) {
    Node* node = pending.back();
    pending.pop_back();
    if (shared(node)) continue;
    {
      const std::lock_guard lock(table().mutex);
      if (node->references.fetch_sub(1, std::memory_order_acq_rel) > 1) continue;
      const auto [first, last] = table().nodes.equal_range(node->hash);
      for (auto it = first; it != last; ++it)
        if (it->second == node) {
          table().nodes.erase(it);
          break;
        }
    }
    for (Expr& a : node->args) pending.push_back(const_cast<Node*>(std::exchange(a.node_, nullptr)));
    delete node;
  }
}

Expr Store::intern(std::unique_ptr<Node> node) {
  std::size_t h = mix(0x8a5cd789635d2dffull, static_cast<std::size_t>(node->op));
  if (node->number) h = hash_text(h, node->number->get_str(36));
  h = hash_text(h, node->name);
  node->total = total_operator(*node);
  node->constant = node->op != Op::Symbol;
  for (const Expr& a : node->args) {
    h = mix(h, a.hash());
    node->total = node->total && a.key()->total;
    node->constant = node->constant && a.key()->constant;
  }
  node->hash = h;
  node->weight = weigh(*node);
  const std::lock_guard lock(table().mutex);
  const auto [first, last] = table().nodes.equal_range(h);
  for (auto it = first; it != last; ++it)
    if (same(*it->second, *node)) {
      retain(it->second);
      return Expr(it->second);
    }
  Node* kept = node.release();
  kept->references = 1;
  table().nodes.emplace(h, kept);
  return Expr(kept);
}

Expr Store::number(const mpq_class& value) {
  auto node = std::make_unique<Node>();
  node->op = Op::Number;
  node->number = std::make_unique<mpq_class>(value);
  node->number->canonicalize();
  return intern(std::move(node));
}

Expr Store::symbol(const std::string& name) {
  auto node = std::make_unique<Node>();
  node->op = Op::Symbol;
  node->name = name;
  return intern(std::move(node));
}

Expr Store::make(Op op, std::vector<Expr> args) {
  auto node = std::make_unique<Node>();
  node->op = op;
  node->args = std::move(args);
  return intern(std::move(node));
}

Expr::Expr() : Expr(0L) {}
Expr::Expr(long value) : Expr(Store::number(mpq_class(value))) {}
Expr::Expr(const Expr& other) noexcept : node_(other.node_) { Store::retain(node_); }
Expr::Expr(Expr&& other) noexcept : node_(std::exchange(other.node_, nullptr)) {}
Expr& Expr::operator=(const Expr& other) noexcept {
  Expr copy(other);
  std::swap(node_, copy.node_);
  return *this;
}
Expr& Expr::operator=(Expr&& other) noexcept {
  std::swap(node_, other.node_);
  return *this;
}
Expr::~Expr() {
  if (node_) Store::release(node_);
}

Op Expr::op() const noexcept { return node_->op; }
std::size_t Expr::arity() const noexcept { return node_->args.size(); }
const Expr& Expr::arg(std::size_t i) const noexcept { return node_->args[i]; }
std::span<const Expr> Expr::args() const noexcept { return node_->args; }
const mpq_class& Expr::number() const noexcept { return *node_->number; }
const std::string& Expr::name() const noexcept { return node_->name; }
bool Expr::is_condition() const noexcept { return node_->op >= Op::Less; }
std::size_t Expr::hash() const noexcept { return node_->hash; }

}  // namespace irt
