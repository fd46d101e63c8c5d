#pragma once

#include <google/protobuf/io/tokenizer.h>

#include <string>

namespace cairn::config {

/// What protobuf's text parser says about a text.
struct ParseError {
  int line = -1;  ///< from 0; -1: the text as a whole
  int column = 0;
  std::string what;
};

/// Keeps the first error; the rest follow from it.
class FirstError : public google::protobuf::io::ErrorCollector {
 public:
  void AddError(int line, int column, const std::string& message) override;
  const ParseError& error() const { return error_; }

 private:
  ParseError error_;
};

/// Throws UsageError for a key that no message has: where, key and the nearest known one.
[[noreturn]] void ThrowUnknown(const std::string& where, const std::string& path);

/// Throws UsageError with where, field, protobuf's message and the field's rule. `outer` is the path of the text's
/// message within the experiment.
[[noreturn]] void ThrowParseError(const ParseError& error, const std::string& text, const std::string& where,
                                  const std::string& outer);

}  // namespace cairn::config
