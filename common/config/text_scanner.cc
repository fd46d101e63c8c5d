#include "common/config/text_scanner.h"

#include <cctype>
#include <vector>

#include "common/config/draft.h"

namespace cairn::config {
namespace {

// Reads tokens one by one and keeps the chain of open blocks plus the field whose value has not been read yet.
class PathScanner {
 public:
  PathScanner(const std::string& text, size_t end) : text_(text), end_(end) {}

  std::string Scan() {
    while (at_ < end_) Next();
    std::string path;
    for (const std::string& block : blocks_) path = JoinPath(path, block);
    return field_.empty() ? path : JoinPath(path, field_);
  }

 private:
  static bool IsWord(char c) { return std::isalnum(static_cast<unsigned char>(c)) || c == '_' || c == '.'; }

  void Next() {
    const char c = text_[at_];
    if (c == '#') return SkipTo('\n');
    if (c == '"' || c == '\'') return String(c);
    if (IsWord(c)) return Word();
    ++at_;
    if (c == ':') value_ = true;
    if (c == '{' || c == '<') Open();
    if (c == '}' || c == '>') Close();
    if (c == '[') list_ = true;
    if (c == ']') list_ = false;
    if (c == ']' || c == ';' || (c == ',' && !list_)) EndField();
  }

  void SkipTo(char c) {
    const size_t found = text_.find(c, at_ + 1);
    at_ = found == std::string::npos ? text_.size() : found + 1;
  }

  void String(char quote) {
    for (++at_; at_ < text_.size() && text_[at_] != quote; ++at_) at_ += text_[at_] == '\\' ? 1 : 0;
    ++at_;
    if (!list_ && at_ <= end_) EndField();
  }

  void Word() {
    const size_t begin = at_;
    while (at_ < text_.size() && IsWord(text_[at_])) ++at_;
    if (at_ > end_) return;
    if (!value_) {
      field_ = text_.substr(begin, at_ - begin);
    } else if (!list_) {
      EndField();
    }
  }

  void Open() {
    blocks_.push_back(field_);
    lists_.push_back(list_);
    list_ = false;
    EndField();
  }

  void Close() {
    EndField();
    if (blocks_.empty()) return;
    list_ = lists_.back();
    if (list_) field_ = blocks_.back(), value_ = true;
    blocks_.pop_back();
    lists_.pop_back();
  }

  void EndField() {
    field_.clear();
    value_ = false;
  }

  const std::string& text_;
  size_t end_;
  size_t at_ = 0;
  std::vector<std::string> blocks_;
  std::vector<bool> lists_;  // per open block: it is an element of a list
  std::string field_;
  bool value_ = false;
  bool list_ = false;
};

size_t Offset(const std::string& text, int line, int column) {
  size_t at = 0;
  for (int i = 0; i < line; ++i) {
    const size_t end = text.find('\n', at);
    if (end == std::string::npos) return text.size();
    at = end + 1;
  }
  // Protobuf's tokenizer counts a tab up to the next multiple of 8.
  for (int seen = 0; seen < column && at < text.size(); ++at) seen += text[at] == '\t' ? 8 - seen % 8 : 1;
  return at;
}

}  // namespace

std::string FieldPathAt(const std::string& text, int line, int column) {
  return PathScanner(text, Offset(text, line, column)).Scan();
}

}  // namespace cairn::config
