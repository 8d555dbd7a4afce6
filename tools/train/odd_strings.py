"""A thousand strings that tokenizers get wrong: the same ones on every machine and Python."""

from random import Random
from unicodedata import ucd_3_2_0

COUNT = 1000

# Each is what one kind of odd text is made of; a string draws from one or from several of them.
_WORDS = (
    "a photo of the teddy bear chair refrigerator unbelievably antidisestablishmentarianism COFFEE Table lamp's "
    "well-known don't 3.14 1,000,000 42nd e.g. i.e. #1 A.B.C. état naïve Ångström façade déjà-vu Größe İstanbul "
    "ΣΊΣΥΦΟΣ ΑΣ ﬁne ﬂat ﬀ"
).split()
_SCRIPTS = (
    "椅子 テディベア 곰인형 泰迪熊 𠀋𠮷 ㍿ ｶﾀｶﾅ ﾊﾟ ＡＢＣ 한국어 漢字かな交じり文",
    "كرسي مَدْرَسَة ﷺ العربية لا ٱلْحَمْدُ ۱۲۳ ٤٥٦",
    "כיסא שָׁלוֹם עִבְרִית ״ציטוט״ ״״ צה״ל",
    "เก้าอี้ น้ำแข็ง ตุ๊กตาหมี กรุงเทพ ๑๒๓",
    "कुर्सी भालू हिन्दी क्षत्रिय ज्ञान १२३ বাংলা தமிழ் తెలుగు ಕನ್ನಡ മലയാളം සිංහල",
    "стул ЁЛКА ёлка Їжак ђ ქართული Հայերեն ΕΛΛΗΝΙΚΆ ελληνικά አማርኛ ᏣᎳᎩ ᠮᠣᠩᠭᠣᠯ ខ្មែរ မြန်မာ བོད་ཡིག ພາສາລາວ",
)
# With what joins and colours them: zero-width joiners, skin tones, variation selectors, flags made of letters and tags.
_EMOJI = (
    "🧸 🪑 👨\u200d👩\u200d👧\u200d👦 🏳\ufe0f\u200d🌈 👩🏽\u200d🚀 ❤\ufe0f 🇨🇭 1\ufe0f\u20e3 ☕ ☎ ⌚\ufe0f 🫠 "
    "🤷🏿\u200d♀\ufe0f \u200d \ufe0f 🏴\U000e0067\U000e0062\U000e0065\U000e006e\U000e0067\U000e007f"
).split(" ")
_MARKS = (
    "e\u0301 a\u0308 n\u0303 \u0301 o\u0302\u0323 \u1ea5 \u00e7 \u0345 Z\u0351\u036b\u0343 q\u0307\u0323 \u20dd \u0489"
).split(" ")
_CONTROLS = "\0 \1 \b \v \f \x1b \x1f \x7f \x80 \x85 \x9f \xad \ufffd \ufffe \ufeff".split(" ")
_SPACES = list("\t\n\r \xa0\u1680\u2003\u2028\u2029\u200b\u200e\u202f\u205f\u3000")
_SURROGATES = ["\ud83d", "\udc00", "\ud800\ud800", "a\udfffb"]
_PUNCTUATION = (
    "! ... ?! —– ‘’ “” «» ¿¡ ‽ 、。 〈〉 · • § ¶ † ‰ € £ ¥ © ® ™ ° ± × ÷ ≠ ∞ √ ^ ` ~ $ + < = > | _ \\ / @ & * ( ) [ ] "
    "{ }"
).split()
_TECHNICAL = (
    "https://example.org/a?b=c&d=%20#e user.name+tag@example.co.uk C:\\Users\\x file_name-v2.tar.gz 192.168.0.1 ::1 "
    "<b>bold</b> &amp; {'a': [1, 2]} SELECT * FROM t; 2026-11-22T10:00:00Z +41 44 123 -1.5e-10 0xDEADBEEF H₂O m² x³ "
    "½ Ⅳ ①"
).split()
_SPECIAL = "[CLS] [SEP] [MASK] [PAD] [UNK] [sep] [unused1] ##ing ## # [SEP][SEP] x[MASK]y".split()
_KINDS = (
    _WORDS, *(script.split() for script in _SCRIPTS), _EMOJI, _MARKS, _CONTROLS, _SPACES, _SURROGATES, _PUNCTUATION,
    _TECHNICAL, _SPECIAL,
)  # fmt: skip


def odd_strings() -> list[str]:
    """``COUNT`` different strings: empty, blank, very long, each kind alone, kinds mixed, characters of any script."""
    random = _Dice(7)
    strings = ["", " ", "\n\t ", "\u3000", "a" * 99, "a" * 100, "a" * 101, "é" * 100, "e\u0301" * 60, "椅" * 200]
    strings += ["word " * 400, "supercalifragilistic" * 300, "🧸" * 150, "\u0301" * 500, "." * 1000, " " * 5000]
    strings += [atom for kind in _KINDS for atom in kind]
    strings += [" ".join(random.of(kind) for _ in range(12)) for kind in _KINDS for _ in range(6)]
    strings += ["".join(random.of(kind) for _ in range(9)) for kind in _KINDS for _ in range(6)]
    strings += ["".join(random.of(random.of(_KINDS)) + " " for _ in range(400)) for _ in range(20)]
    # Assigned in Unicode 3.2, so that what they are depends on nobody's version of Unicode.
    assigned = [c for c in map(chr, range(0x3000)) if ucd_3_2_0.category(c) != "Cn"]
    strings += ["".join(random.of(assigned) for _ in range(1 + random.below(10))) for _ in range(130)]
    different = dict.fromkeys(strings)
    while len(different) < COUNT:
        parts = [random.of(random.of(_KINDS)) for _ in range(1 + random.below(14))]
        different["".join(part + random.of(("", " ", " ")) for part in parts)] = None
    return list(different)


class _Dice:
    """Draws that follow from ``Random.random`` alone, which Python promises never to change for a seed."""

    def __init__(self, seed: int):
        self._random = Random(seed)

    def below(self, limit: int) -> int:
        return int(self._random.random() * limit)

    def of(self, choices):
        return choices[self.below(len(choices))]
