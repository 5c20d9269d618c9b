/* The layout of UF_Value: profile @{name}, @{state}.
 * @{found}.
 * Emitted by linewright; choose another profile with `build --profile FILE`. */
#ifndef LW_UF_PROFILE_H
#define LW_UF_PROFILE_H

#define LW_UF_SIZE @{size}
#define LW_UF_VALUE_OFFSET @{value_offset}
#define LW_UF_INTEGER int@{integer_bits}_t
#define LW_UF_ENCODING @{encoding}
#define LW_UF_TAG_OFFSET @{tag_offset}
#define LW_UF_TAG uint@{tag_bits}_t
#define LW_UF_TAG_INTEGER @{tag_integer}U
#define LW_UF_TAG_REAL @{tag_real}U
#define LW_UF_TAG_STRING @{tag_string}U
@ if tag_boolean != none
#define LW_UF_TAG_BOOLEAN @{tag_boolean}U
@ endif
@ if more_real
#define LW_UF_MORE_REAL(tag) (@% for tag in more_real %@(tag) == @{tag}U@{" || " if not loop.last else ""}@% endfor %@)
@ endif

#endif
