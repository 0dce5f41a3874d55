"""From text to plain words: spelling, contractions, hesitations, punctuation."""

import re
from dataclasses import dataclass

from attune.dialogue.words import words

_CONTRACTIONS = {
    "i'm": "i am", "im": "i am", "i'd": "i would", "id": "i would", "i'll": "i will", "i've": "i have", "ive": "i have",
    "you're": "you are", "you'd": "you would", "you'll": "you will", "you've": "you have", "youre": "you are",
    "he's": "he is", "she's": "she is", "he'd": "he would", "she'd": "she would", "he'll": "he will",
    "she'll": "she will", "it's": "it is", "it'd": "it would", "it'll": "it will", "we're": "we are",
    "we'd": "we would", "we'll": "we will", "we've": "we have", "they're": "they are", "they'd": "they would",
    "they'll": "they will", "they've": "they have", "that's": "that is", "thats": "that is", "that'd": "that would",
    "that'll": "that will", "there's": "there is", "theres": "there is", "here's": "here is", "what's": "what is",
    "whats": "what is", "where's": "where is", "wheres": "where is", "who's": "who is", "how's": "how is",
    "let's": "let us", "lets": "let us", "can't": "can not", "cant": "can not", "cannot": "can not",
    "won't": "will not", "wont": "will not", "shan't": "shall not", "wanna": "want to", "gonna": "going to",
    "gotta": "have to", "gimme": "give me", "lemme": "let me", "dunno": "do not know", "'em": "them",
    "coulda": "could have", "kinda": "kind of", "sorta": "sort of", "y'all": "you all", "ain't": "is not",
    "o'clock": "oclock", "'cause": "because", "cos": "because", "cuz": "because", "coz": "because", "pls": "please",
    "plz": "please", "ya": "you", "u": "you", "mom's": "mom is", "mum's": "mum is", "yep": "yes", "yeah": "yes",
    "yup": "yes", "yah": "yes", "nope": "no", "nah": "no", "ok": "okay", "k": "okay", "colour": "color",
    "colours": "colors", "coloured": "colored", "thx": "thanks", "ta": "thanks", "cheers": "thanks",
    "tha": "you", "thou": "you", "thee": "you", "ye": "you", "yous": "you all", "yer": "your", "yon": "that",
    "yonder": "that", "gie": "give", "gies": "give us", "gie's": "give us", "oot": "out", "doon": "down", "fae": "from",
    "frae": "from", "dat": "that", "de": "the", "da": "the", "dis": "this", "dem": "them",
    "nae": "no", "didnae": "did not", "dinnae": "do not", "dinna": "do not", "cannae": "can not", "isnae": "is not",
    "wasnae": "was not", "o'": "of", "hol'": "hold",
    "wi'": "with", "an'": "and", "aye": "yes", "naw": "no", "summat": "something",
    "owt": "anything", "nowt": "nothing", "haud": "hold", "gotten": "got", "outta": "out of", "offa": "off",
    "tae": "to", "nvm": "never mind", "'ang": "hang", "'old": "hold",
    "ma": "my", "anymore": "any more", "'til": "until", "till": "until", "nevermind": "never mind",
}  # fmt: skip

HESITATIONS = words(
    "eww ew ugh argh aargh yuck tsk phew pff um uh er erm hm hmm hmmm umm uhm uhh ehm eh ah ahem "
    "mhm-mhm err uhmm äh mm oh ooh aah aw"
)

_G_DROPPED = re.compile(r"(?<=\w{2}in)['’](?!\w)")
_THE_CUT_SHORT = re.compile(r"\bt['’](?=[a-z]{3})", re.IGNORECASE)
_OUT_OF = re.compile(
    r"\b(out|oot) (?=(?:the|that|your|my|our) (?:\w+ )?(?:fridge|drawer|cupboard|cabinet|dishwasher)\b)"
)
_A_LITTLE_MORE = re.compile(
    r"\ba little(?= *(?:[.,!?;]|$)| (?:slower|faster|louder|quieter|softer|closer|nearer|further|farther|longer|later|"
    r"more \w+ly)\b)",
    re.IGNORECASE,
)
"""Where it says how much, and is no size."""
_STUTTERED = re.compile(r"\b([a-z]{1,3})(?:-\s?\1)*-\s?(?=\1)", re.IGNORECASE)
"""The false starts of a word: "g-get", "b-b-blue", "mi-milk"."""
_STOP_DRAWN_OUT = re.compile(r"\bst(?:o|oh|ah|aw)?(?:-?o)+-?p\b|\bstah?p\b|\bsstop\b", re.IGNORECASE)
_DRAWN_OUT = re.compile(r"([a-z])\1{2,}")
_TOKEN = re.compile(
    r"\b(?:o|wi|an|hol)['’](?!\w)|[a-zäöüéèàç0-9]+(?:['’][a-z]+)*|['’][a-z]+|[.!?…]+|[,;:—–()\"]|\s-+\s", re.IGNORECASE
)


@dataclass(frozen=True, slots=True)
class Token:
    """A word, or a break: "," weak, "." strong.

    Attributes:
        capital: It was written with a capital letter, not at the beginning of a sentence.
    """

    text: str
    capital: bool = False


def tokenize(text: str) -> list[Token]:
    """Words in lower case with contractions written out and hesitations left out; punctuation as "," and "."."""
    tokens: list[Token] = []
    text = _STOP_DRAWN_OUT.sub("stop", _STUTTERED.sub("", text))
    text = _THE_CUT_SHORT.sub("the ", _G_DROPPED.sub("g", re.sub(r"(?<=\w)-(?=\w)", " ", text)))
    text = _A_LITTLE_MORE.sub("a bit", _OUT_OF.sub(r"\1 of ", text))
    for match in _TOKEN.finditer(text):
        piece = match[0]
        if not piece[0].isalnum() and piece[0] not in "'’":
            mark = "?" if "?" in piece else "." if piece[0] in ".!…" else ","
            if tokens and tokens[-1].text not in {",", ".", "?"}:
                tokens.append(Token(mark))
            elif tokens and mark != ",":
                tokens[-1] = Token(mark)
            continue
        word = piece.lower().replace("’", "'")
        capital = piece[0].isupper() and bool(tokens) and tokens[-1].text not in {".", "?"}
        if word in HESITATIONS:
            continue
        word = _DRAWN_OUT.sub(r"\1", word)  # "stooop", "pleaaase"
        for part in _expand(word):
            tokens.append(Token(part, capital))
    while tokens and tokens[-1].text == ",":
        tokens.pop()
    return tokens


def _expand(word: str) -> list[str]:
    if word in _CONTRACTIONS:
        return _CONTRACTIONS[word].split()
    if word.endswith("n't"):
        return [word[:-3], "not"]
    if word.endswith("nt") and word[:-2] in {"do", "did", "does", "have", "is", "are", "was", "would", "could"}:
        return [word[:-2], "not"]
    if word.endswith(("'re", "'ve", "'ll")):
        return [word[:-3], {"re": "are", "ve": "have", "ll": "will"}[word[-2:]]]
    if word.endswith("'d"):
        return [word[:-2], "would"]
    # "anna's": a name's genitive is of no use here, but "cup's" may be "cup is".
    return [word[:-2], "'s"] if word.endswith("'s") else [word.strip("'")]
