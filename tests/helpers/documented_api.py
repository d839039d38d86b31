"""Holds what the API answers against what its description promises."""

import functools
import re

import httpx

from tests.helpers.served import served
from vizbot.operator.api import answers, errors


@functools.cache
def description():
    """What the API publishes of itself."""
    with served() as server:
        return httpx.get(f"{server.url}/openapi.json", timeout=60.0).json()


class DocumentedClient(httpx.Client):
    """A client that checks every answer: its status, its content type, and its model."""

    def __init__(self, url, **options):
        super().__init__(base_url=url, event_hooks={"response": [_check]}, **options)


def _check(response):
    request = response.request
    operation = _operation(request.method.lower(), request.url.path)
    if operation is None:
        assert response.status_code in (404, 405) or request.url.path == "/openapi.json"
        return
    documented = operation["responses"].get(str(response.status_code))
    assert documented, f"{request.url.path} does not document {response.status_code}"
    content_type = response.headers["content-type"]
    schema = documented["content"][content_type]["schema"]
    response.read()
    if content_type == "application/json":
        assert_fits(response.json(), schema)


def _operation(method, path):
    for template, operations in description()["paths"].items():
        if re.fullmatch(re.sub(r"\{\w+\}", "[^/]+", template), path):
            return operations.get(method)
    return None


def assert_fits(answer, schema):
    """Check that an answer has the fields of its model, each with its type, and no others."""
    name = schema["$ref"].rsplit("/", 1)[1]
    model = getattr(answers, name, None) or getattr(errors, name)
    assert model.model_validate(answer).model_dump(mode="json", exclude_unset=True) == answer
