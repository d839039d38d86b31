"""How people at home name a thing to a robot; the text stage learns these phrasings.

Fields of a phrasing: {bare} "sofa", {a} "a sofa", {the} "the sofa", {many} "sofas". A fifth of the
phrasings is withheld: no training text has one of them, nor its adjective. They are drawn by a seed
from lists that were complete before the first training. A fifth of the synonyms of the vocabulary
is withheld likewise, to examine the look-up of words on them.
"""

from __future__ import annotations

import re
from collections.abc import Mapping

import numpy as np

from training.captions.phrasing import NounPhrase, phrased, plural_noun
from vizbot.core.home_vocabulary import ROOMS, SYNONYMS

SEED = 0
"""Seed of the draw of what is withheld."""
WITHHELD_SHARE = 0.2
"""Share of the phrasings that is withheld."""

DETERMINERS = (
    "my {bare}", "our {bare}", "your {bare}", "his {bare}", "her {bare}", "their {bare}",
    "this {bare}", "that {bare}", "one {bare}", "any {bare}", "another {bare}", "the other {bare}",
    "each {bare}", "every {bare}", "which {bare}?", "the same {bare}", "the next {bare}",
    "the first {bare}", "the last {bare}", "just {a}", "only {the}", "a certain {bare}",
    "grandma's {bare}", "the neighbour's {bare}", "the children's {bare}", "some sort of {bare}",
    "a kind of {bare}", "at least one {bare}", "what a {bare}", "such {a}",
)  # fmt: skip
"""Articles, possessives and the like."""

PLURALS = (
    "{many}", "the {many}", "some {many}", "my {many}", "our {many}", "these {many}",
    "those {many}", "all the {many}", "all {many}", "any {many}", "more {many}", "a few {many}",
    "both {many}", "find {many}", "find the {many}", "find some {many}", "go to the {many}",
    "where are the {many}?", "where are my {many}", "show me the {many}", "are there any {many}?",
    "one of the {many}", "look for {many}", "are there {many} here", "there are {many}",
    "most {many}", "which {many} are there?", "take me to the {many}", "a place with {many}",
)  # fmt: skip
"""Phrasings of the plural."""

ADJECTIVES = (
    "nice", "big", "old", "small", "large", "little", "new", "beautiful", "comfortable", "cosy",
    "lovely", "good", "great", "fine", "pretty", "modern", "antique", "huge", "tiny",
    "tall", "low", "long", "short", "wide", "narrow", "heavy", "lightweight", "clean", "dirty",
    "dusty", "broken", "fancy", "simple", "plain", "cheap", "expensive", "elegant", "stylish",
    "vintage", "rustic", "favourite", "usual", "ordinary", "normal", "typical", "real", "empty",
    "free", "second-hand", "spare", "main", "central", "closest", "nearby", "furthest",
    "right", "left", "correct", "well-known", "strange", "odd", "funny", "gorgeous",
    "wonderful", "amazing", "perfect", "decent", "neat", "tidy", "messy", "shiny", "dull", "soft",
    "hard", "solid", "sturdy", "fragile", "bulky", "compact", "round", "square", "rectangular",
    "oval", "bright", "dark", "pale", "colourful", "striped", "painted", "polished", "worn",
    "worn-out", "shabby", "fresh", "warm", "cold", "quiet", "famous", "unusual",
    "special", "classic", "traditional", "contemporary", "scandinavian", "victorian",
    "japanese", "handmade", "homemade", "designer", "luxurious", "humble", "friendly",
    "charming", "adorable", "cute", "impressive", "enormous", "giant", "miniature", "medium-sized",
    "oversized", "full-size", "ancient", "brand-new", "recent", "present", "missing", "lost",
    "hidden", "well-made", "borrowed", "bought", "wanted", "requested",
)  # fmt: skip
"""Adjectives that say nothing the encoder could see for sure: the thing's name decides."""

REQUESTS = (
    "fetch me {a}", "lead me to {the}", "lead the way to {the}", "walk me to {the}",
    "escort me to {the}", "accompany me to {the}", "follow me to {the}", "come to {the}",
    "come over to {the}", "come with me to {the}", "go over to {the}", "go straight to {the}",
    "go back to {the}", "go and find {the}", "go and look for {a}", "go look at {the}",
    "now go to {the}", "then go to {the}", "and then {the}", "first {the}", "next {the}",
    "to {the}", "to {the}, please", "towards {the}", "over to {the}", "back to {the}",
    "drive over to {the}", "drive me to {the}", "drive back to {the}", "drive up to {the}, please",
    "please drive to {the}", "please find {the}", "please find me {a}", "please look for {a}",
    "please take me to {the}", "please show me {the}", "please bring me to {the}",
    "please stop at {the}", "please come to {the}", "kindly go to {the}", "be so kind and find {a}",
    "go to {the}, please", "find {the}, please", "show me {the}, please",
    "take me to {the}, please", "could you go to {the}?", "could you find {the}?",
    "could you please find {a}?", "could you show me {the}?", "could you take me to {the}",
    "could you drive to {the}", "can you go to {the}?", "can you see {the}?", "can you see {a}",
    "can you show me {the}?", "can you take me to {the}?", "can you look for {the}",
    "would you go to {the}?", "would you find {the}?", "would you please go to {the}",
    "would you mind going to {the}", "will you go to {the}?", "will you find {a} for me",
    "may i see {the}?", "may i have {a}", "i want {a}", "i want {the}", "i want to see {the}",
    "i want to find {the}", "i would like {a}", "i would like to see {the}",
    "i would like to go to {the}", "i'd like {a}", "i'd like to go to {the}", "i need {the}",
    "i need to find {the}", "i need to get to {the}", "i have to go to {the}",
    "i am searching for {the}", "i'm looking for {the}", "i'm looking for {a}", "i lost {the}",
    "i cannot find {the}", "i can't find {the}", "i forgot where {the} is",
    "i wonder where {the} is", "i think there is {a}", "i like {the}",
    "i left it at {the}", "i left my keys near {the}", "my keys are by {the}",
    "we need {a}", "we want to go to {the}", "we are looking for {a}", "we should go to {the}",
    "let's go to {the}", "let's find {the}", "let's see {the}", "let's drive to {the}",
    "where is there {a}?", "where is my {bare}?", "where is our {bare}", "where's {the}",
    "where's {the}?", "where's my {bare}?", "where do i find {the}?", "where do we keep {the}?",
    "where did you see {the}?", "where did i put {the}", "where might {the} be?",
    "where could {the} be", "where would i find {a}?", "where can {the} be found?",
    "do you know where {the} is?", "do you know {the}?", "do you see {the}?", "do you see {a}",
    "do we have {a}?", "do you have {a}?", "did you see {the}?", "did you find {the}?",
    "have you seen {the}?", "have you seen {a}", "have we got {a}?", "is this {the}?",
    "is that {a}?", "is {the} here?", "is there {a} here?", "is there {a} nearby?",
    "is there {a} in this house?", "is there any {bare}?", "isn't there {a}?",
    "are we at {the}?", "are you at {the}", "are you near {the}?", "how do i get to {the}?",
    "how far is {the}?", "how do we reach {the}", "which way to {the}?", "what about {the}?",
    "what about {a}", "how about {a}?", "who has {a}?", "any {bare} around?", "got {a}?",
    "tell me where {the} is", "tell me about {the}", "say where {the} is", "show {the}",
    "show us {the}", "show me where {the} is", "point me to {the}", "point at {the}",
    "point out {the}", "direct me to {the}", "steer to {the}", "steer towards {the}",
    "roll to {the}", "ride to {the}", "run to {the}", "walk to {the}", "hurry to {the}",
    "rush to {the}", "proceed to {the}", "continue to {the}", "advance to {the}",
    "set off for {the}", "turn to {the}", "turn towards {the}", "face {the}", "look at {the}",
    "look around for {the}", "look out for {a}", "watch {the}", "check {the}", "check on {the}",
    "check whether there is {a}", "visit {the}", "see {the}", "seek {the}", "seek out {a}",
    "spot {the}", "discover {a}", "detect {a}", "identify {the}", "recognise {the}",
    "explore until you see {a}", "reach {the}", "meet me at {the}", "wait at {the}",
    "wait for me at {the}", "wait near {the}", "stay at {the}", "stay by {the}", "stand by {the}",
    "stand in front of {the}", "stop near {the}", "stop by {the}", "stop in front of {the}",
    "halt at {the}", "park at {the}", "park in front of {the}", "clean near {the}",
    "vacuum around {the}", "clean around {the}", "deliver this to {the}", "carry this to {the}",
    "bring this to {the}", "bring it to {the}", "put it on {the}", "the goal is {the}",
    "your goal is {the}", "the target is {the}", "destination: {the}", "goal: {bare}",
    "target: {bare}", "destination {bare}", "the way to {the}", "the place with {the}",
    "the place where {the} is", "the spot with {the}", "somewhere near {the}",
    "anything like {a}", "anything that looks like {a}", "something that is {a}",
    "a thing called {a}", "what people call {a}", "what we call {the}", "known as {a}",
    "an object such as {a}", "an example of {a}", "hey, where is {the}?", "hey, go to {the}",
    "hey robot, find {the}", "hello, take me to {the}", "hi, go to {the}",
    "robot, find {the}", "robot, where is {the}?", "robot, take me to {the}",
    "ok, go to {the}", "okay, now {the}", "alright, {the}", "well, {the}", "yes, {the}",
    "no, {the}", "quick, {the}", "{the} now", "{the} next", "{the} first", "{a}, quickly",
    "{a} would be nice", "{the} over there", "{the} at home", "{the} of this house",
    "{the} in here", "{the} in this home", "{a} for me", "{a} for us", "{the} again",
    "{the}, robot", "{the}?", "{a}?", "{bare}!", "{the}!", "{bare} here", "{bare} there",
)  # fmt: skip
"""Requests, questions and remarks."""

PICTURED = (
    "a drawing of {a}", "a painting of {the}", "an illustration of {a}", "a video of {a}",
    "a video frame with {a}", "a film of {the}", "a portrait of {a}", "a scan of {a}",
    "a screenshot showing {a}", "a camera view of {the}", "a dark photo of {a}",
    "a colour photo of {a}", "an old photo of {the}", "a photograph of {a}",
    "photograph of {the}", "image of {a}", "image of {the}", "an image showing {the}",
    "an image with {a} in it", "a picture with {a}", "a picture that shows {the}",
    "a shot of {a}", "a detailed photo of {a}", "a scene with {a}", "a room scene with {the}",
    "in this picture there is {a}", "in the image we see {the}", "a view with {the}",
)  # fmt: skip
"""Captions of pictures."""


def _of_adjective(adjective: str) -> str:
    return f"{'an' if adjective[0] in 'aeiou' else 'a'} {adjective} {{bare}}"


SPOKEN = tuple(
    dict.fromkeys((*DETERMINERS, *PLURALS, *map(_of_adjective, ADJECTIVES), *REQUESTS, *PICTURED))
)
"""All phrasings of the text stage; an adjective is one phrasing, with an article."""


def _split() -> tuple[tuple[str, ...], tuple[str, ...]]:
    chosen = np.random.default_rng(SEED).permutation(len(SPOKEN))
    withheld = set(chosen[: round(WITHHELD_SHARE * len(SPOKEN))].tolist())
    trained = tuple(way for i, way in enumerate(SPOKEN) if i not in withheld)
    return trained, tuple(way for i, way in enumerate(SPOKEN) if i in withheld)


TRAINED_SPOKEN, WITHHELD_SPOKEN = _split()
"""The phrasings that training may use, and those that it must not."""
TRAINED_ADJECTIVES = tuple(it for it in ADJECTIVES if _of_adjective(it) in TRAINED_SPOKEN)
"""Adjectives that training may put before any noun."""


def spoken(way: str, words: str) -> str:
    """A phrasing about a noun: ("some {many}", "red sofa") is "some red sofas"."""
    return phrased(way.replace("{many}", plural_noun(words)), NounPhrase.from_name(words))


_ALL_SYNONYMS = tuple(
    (word, name) for table in (SYNONYMS, ROOMS) for name, words in table.items() for word in words
)


def _withheld_synonyms() -> Mapping[str, str]:
    count = round(WITHHELD_SHARE * len(_ALL_SYNONYMS))
    chosen = np.random.default_rng((SEED, 1)).permutation(len(_ALL_SYNONYMS))[:count]
    return {_ALL_SYNONYMS[i][0]: _ALL_SYNONYMS[i][1] for i in sorted(chosen.tolist())}


WITHHELD_SYNONYMS: Mapping[str, str] = _withheld_synonyms()
"""Class or room of each withheld synonym."""
TRAINED_SYNONYMS: Mapping[str, str] = {
    word: name for word, name in _ALL_SYNONYMS if word not in WITHHELD_SYNONYMS
}
"""Class or room of each of the others."""

_WITHHELD_WORDS = re.compile(rf"\b({'|'.join(map(re.escape, WITHHELD_SYNONYMS))})(e?s)?\b")


def has_withheld_synonym(text: str) -> bool:
    """Whether a text has one of the withheld synonyms, also in the plural."""
    return _WITHHELD_WORDS.search(text) is not None
